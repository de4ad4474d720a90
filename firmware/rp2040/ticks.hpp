// SPDX-License-Identifier: MIT
// The board's clock: 64 bits, 8 ns.
#pragma once

#include "firmware/rp2040/registers.hpp"

namespace glint::rp2040 {

inline constexpr uint32_t kTicksPerUs = 125;

/// The fine part, which wraps every 134 ms; one instruction, for use beside whatever is to be timed.
inline uint32_t fine_tick() { return 0xffffff - cortex::kSysTickValue.read(); }

/// Microseconds since reset, low half.
inline uint32_t now_us() { return timer::kRawLow.read(); }

/// Starts the fine counter; TIMER and PLL must run.
void start_ticks();
/// The full tick of a fine one that was read less than 60 ms ago.
uint64_t full_tick(uint32_t fine);
inline uint64_t now_tick() { return full_tick(fine_tick()); }

}  // namespace glint::rp2040
