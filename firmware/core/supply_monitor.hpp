// SPDX-License-Identifier: MIT
// Watches the supply of the lights.
#pragma once

#include "firmware/core/limits.hpp"

namespace glint::board {

/// Fed with every sample of the supply. One sample is not enough to trip, as it may be a disturbance; two in
/// a row are, 0.1 ms at the board's 20 kHz.
class SupplyMonitor {
 public:
  static constexpr uint32_t kSampleHz = 20'000;
  static constexpr uint32_t kSamplesToTrip = 2;
  static constexpr uint32_t kSamplesToRearm = kSampleHz / 100;

  void add(uint16_t mv, const StrobeLimits& limits) {
    if (mv <= limits.lockout_mv)
      above_ = 0;
    else if (above_ < kSamplesToTrip)
      ++above_;
    if (mv >= limits.rearm_mv)
      below_ = 0;
    else if (below_ < kSamplesToRearm)
      ++below_;
    sum_ = sum_ - average_mv() + mv;
  }
  bool too_high() const { return above_ == kSamplesToTrip; }
  /// Below the limit for re-arming, for 10 ms without a break.
  bool low_enough() const { return below_ == kSamplesToRearm; }
  /// Over some 3 ms.
  uint16_t average_mv() const { return static_cast<uint16_t>(sum_ / kAverage); }

 private:
  static constexpr uint32_t kAverage = 64;
  uint32_t sum_ = 0;
  uint32_t above_ = 0, below_ = 0;
};

}  // namespace glint::board
