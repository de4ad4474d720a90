// SPDX-License-Identifier: MIT
// Where everything is on a Raspberry Pi Pico; hardware/sync-carrier/pinout.csv lists the same for people.
#pragma once

#include <stdint.h>

namespace glint::rp2040 {

inline constexpr unsigned kPinTrigger0 = 2;     // to 5: camera triggers
inline constexpr unsigned kPinStrobe0 = 6;      // to 9: light drivers
inline constexpr unsigned kPinStrobesLow = 10;  // jumper to ground: strobes are active low
inline constexpr unsigned kPinSyncIn = 14;
inline constexpr unsigned kPinSyncOut = 15;
inline constexpr unsigned kPinGate = 23;  // not on the header: its input starts all outputs in one tick
inline constexpr unsigned kPinLed = 25;
inline constexpr unsigned kPinSupply = 26;  // ADC 0
inline constexpr unsigned kAdcSupply = 0;
/// The divider of the supply: 70 kOhm over 10 kOhm, so that 26.4 V would be full scale.
inline constexpr uint32_t kSupplyFullScale_mv = 3300 * 8;

}  // namespace glint::rp2040
