// SPDX-License-Identifier: MIT
#include "firmware/rp2040/ticks.hpp"

namespace glint::rp2040 {
namespace {

uint32_t g_fine_offset;  // fine tick at which the timer's microseconds began, modulo 2^24

uint64_t us_as_ticks() {
  uint32_t high = timer::kRawHigh.read();
  for (;;) {
    const uint32_t low = timer::kRawLow.read();
    const uint32_t again = timer::kRawHigh.read();
    if (high == again) return (uint64_t{high} << 32 | low) * kTicksPerUs;
    high = again;
  }
}

}  // namespace

void start_ticks() {
  cortex::kSysTickReload.write(0xffffff);
  cortex::kSysTickValue.write(0);
  cortex::kSysTickControl.write(bit(0) | bit(2));  // on, at the processor's clock, no interrupt
  const uint32_t us = now_us();
  while (now_us() == us) {
  }
  g_fine_offset = fine_tick() - (us + 1) * kTicksPerUs;
}

// Both counters hang on the same crystal, so that the timer only has to say which turn of the fine one it is.
uint64_t full_tick(uint32_t fine) {
  const uint64_t coarse = us_as_ticks();
  const uint32_t ahead = (fine - g_fine_offset - static_cast<uint32_t>(coarse)) << 8;
  return coarse + static_cast<uint64_t>(static_cast<int64_t>(static_cast<int32_t>(ahead) >> 8));
}

}  // namespace glint::rp2040
