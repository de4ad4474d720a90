// SPDX-License-Identifier: MIT
// What the state machines of the PIO run, and how many ticks it takes.
#pragma once

#include <stdint.h>

namespace glint::rp2040::pulse_program {

// Encodings of the datasheet, section 3.4. With one side-set bit, bit 12 is the level of the output.
constexpr uint16_t kHigh = 1u << 12;
constexpr uint16_t jump(unsigned condition, unsigned to) {
  return static_cast<uint16_t>(condition << 5 | to);
}
enum Condition : unsigned { kAlways = 0, kXZero = 1, kXDown = 2, kPin = 6 };
constexpr uint16_t wait_for_high(unsigned pin) { return static_cast<uint16_t>(0x2080 | pin); }
inline constexpr uint16_t kPull = 0x80a0, kPush = 0x8000;
inline constexpr uint16_t kXFromOsr = 0xa027, kXAllOnes = 0xa02b, kIsrFromNotX = 0xa0c9;
inline constexpr uint16_t kSetPinsHigh = 0xe001, kSetPinsLow = 0xe000, kSetPinsOut = 0xe081;

/// A segment: `low` ticks low, then `width` ticks high unless width is 0. Waits low for its words, so that a
/// dead processor leaves all outputs low, and for the gate. The set pin (sync out) follows the output.
inline constexpr unsigned kPulseLength = 10, kWaitLine = 2;
constexpr uint16_t pulse(unsigned line, unsigned gate_pin) {
  switch (line) {
    case 0:
      return kPull;
    case 1:
      return kXFromOsr;
    case 2:
      return wait_for_high(gate_pin);
    case 3:
      return jump(kXDown, 3);
    case 4:
      return kPull;
    case 5:
      return kXFromOsr;
    case 6:
      return jump(kXZero, 0);
    case 7:
      return kSetPinsHigh | kHigh;
    case 8:
      return jump(kXDown, 8) | kHigh;
    default:
      return kSetPinsLow;
  }
}
// Ticks that a segment takes beside its counts, from the table of cycles: lines 3-6 after the gate is seen
// (x + 4, then line 7 rises); lines 9, 0-6 after a pulse; lines 0-6 after no pulse; lines 7-8 high.
inline constexpr uint32_t kLowAfterGate = 5, kLowAfterPulse = 8, kLowAfterNone = 7, kWidthBeside = 2;

// Ticks from one edge to the next beside two a count.
inline constexpr uint32_t kMeasureLow = 4, kMeasureHigh = 3, kMeasureResolution = 2;
/// Measures the jump pin: pushes how long it was low, then how long it was high, for ever; two ticks a count.
inline constexpr unsigned kMeasureStart = 16, kMeasureLength = 10;
constexpr uint16_t measure(unsigned line) {
  switch (line) {
    case 0:
      return kXAllOnes;
    case 1:
      return jump(kPin, kMeasureStart + 3);  // low: until the pin is high
    case 2:
      return jump(kXDown, kMeasureStart + 1);
    case 3:
      return kIsrFromNotX;
    case 4:
      return kPush;
    case 5:
      return kXAllOnes;
    case 6:
      return jump(kXDown, kMeasureStart + 7);  // high: while the pin is high
    case 7:
      return jump(kPin, kMeasureStart + 6);
    case 8:
      return kIsrFromNotX;
    default:
      return kPush;
  }
}
}  // namespace glint::rp2040::pulse_program
