// SPDX-License-Identifier: MIT
// Quantiles of many positive numbers without keeping them.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace glint::sim {

/// Counts by the logarithm of the value, in steps of 1 %. What is below 1e-9 counts as that, what is above
/// 1e6 as that.
class LogHistogram {
 public:
  void add(double value) noexcept;
  /// The value that a share `q` (0 to 1) of all does not exceed, to half a step; 0 while there is none.
  double quantile(double q) const noexcept;
  double median() const noexcept { return quantile(0.5); }

 private:
  static constexpr double kLowest = 1e-9;
  static constexpr std::size_t kBinsPerDecade = 230;
  std::array<std::uint64_t, 15 * kBinsPerDecade> bins_{};
  std::uint64_t count_ = 0;
};

}  // namespace glint::sim
