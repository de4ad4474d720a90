// SPDX-License-Identifier: MIT
// Median of many pixel distances in little memory.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

namespace glint::health {

/// Bins of 5 % from a thousandth of a pixel to two hundred.
class ResidualHistogram {
 public:
  void add(double distance_px) noexcept {
    const double bin = std::log(std::max(distance_px, kLeast_px) / kLeast_px) / kStep;
    ++counts_[std::min(static_cast<std::size_t>(bin), counts_.size() - 1)];
    ++total_;
  }
  /// Middle of the median's bin; 0 if nothing was added.
  double median_px() const noexcept {
    std::uint64_t below = 0;
    for (std::size_t n = 0; n < counts_.size(); ++n) {
      below += counts_[n];
      if (2 * below > total_) return kLeast_px * std::exp((static_cast<double>(n) + 0.5) * kStep);
    }
    return 0.0;
  }

 private:
  static constexpr double kLeast_px = 1e-3, kStep = 0.05;
  std::array<std::uint64_t, 250> counts_{};
  std::uint64_t total_ = 0;
};

}  // namespace glint::health
