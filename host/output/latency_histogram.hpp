// SPDX-License-Identifier: MIT
// Counts durations in fine logarithmic bins: percentiles of any number of ticks in fixed memory.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace glint {

/// 1 us to 1000 s; quantiles are right to 0.6 %, the smallest and largest value are exact. Thread-bound;
/// add() allocates nothing.
class LatencyHistogram {
 public:
  LatencyHistogram();

  /// Negative and non-finite values are not counted.
  void add(double seconds) noexcept;
  std::uint64_t count() const noexcept { return count_; }
  double min_s() const noexcept { return count_ == 0 ? 0.0 : min_s_; }
  double max_s() const noexcept { return count_ == 0 ? 0.0 : max_s_; }
  /// fraction in 0..1: the value that this share of all values does not exceed; 0 without values.
  double quantile_s(double fraction) const noexcept;
  /// How many values lie in [from_s, to_s), as far as bins can tell.
  std::uint64_t count_between(double from_s, double to_s) const noexcept;

 private:
  std::vector<std::uint64_t> bins_;
  std::uint64_t count_ = 0;
  double min_s_ = 0.0, max_s_ = 0.0;
};

}  // namespace glint
