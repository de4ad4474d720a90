// SPDX-License-Identifier: MIT
// What the board may do at most, whatever its host asks for. Times are ticks.
#pragma once

#include <stdint.h>

namespace glint::board {

inline constexpr uint32_t kTickHz = 125'000'000;
constexpr uint32_t ticks_of_us(uint32_t us) { return us * (kTickHz / 1'000'000); }

inline constexpr uint32_t kMinPeriod = ticks_of_us(500);
inline constexpr uint32_t kMaxPeriod = ticks_of_us(10'000'000);
inline constexpr uint32_t kMinWidth = ticks_of_us(1);
/// Between two pulses of one output; the pulse program needs 8 ticks, and this leaves a visible gap.
inline constexpr uint32_t kMinGap = ticks_of_us(1);

/// Caps of the light: the ring of the thesis takes 265 us at 90 Hz (24 permille) and is used up to 13.8 V.
inline constexpr uint32_t kCapStrobeWidth = ticks_of_us(300);
inline constexpr uint16_t kCapStrobeDuty_permille = 25;
inline constexpr uint16_t kCapLockout_mv = 14'000;
inline constexpr uint16_t kCapRearm_mv = 13'800;
inline constexpr uint16_t kLeastHysteresis_mv = 100;

/// Limits of the light in force: the caps, or less where the host asked for less.
struct StrobeLimits {
  uint16_t lockout_mv = kCapLockout_mv;
  uint16_t rearm_mv = kCapRearm_mv;
  uint16_t max_duty_permille = kCapStrobeDuty_permille;
  uint32_t max_width = kCapStrobeWidth;

  /// From the rise of a pulse of that width, at most the cap, to the next rise at the earliest.
  constexpr uint32_t least_interval(uint32_t width) const {
    return (width * 1000 + max_duty_permille - 1u) / max_duty_permille;
  }
};

}  // namespace glint::board
