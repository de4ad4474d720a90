// SPDX-License-Identifier: MIT
// The straight lines that a set of inequalities allows, as a convex polygon.
#pragma once

#include <array>
#include <cstddef>

namespace glint::sync {

/// Lines y = offset + rate * x, as a convex polygon in the plane (offset, rate): each inequality cuts a piece
/// off. No allocation.
class FeasibleLines {
 public:
  struct Range {
    double least = 0.0, most = 0.0;
  };

  /// All lines with offset and rate in these ranges.
  void start(Range offset, Range rate) noexcept;

  /// Keeps the lines that are at most (at least) `y` at `x`. If there is none, nothing changes: false.
  bool keep_below(double x, double y) noexcept { return cut(-1.0, -x, y); }
  bool keep_above(double x, double y) noexcept { return cut(1.0, x, -y); }

  Range at(double x) const noexcept;
  Range rate() const noexcept;

 private:
  struct Corner {
    double offset, rate;
  };
  // Each inequality adds one at most, and in the end there are seldom more than a dozen. A cut for which
  // there is no room is left out: that allows too much, but nothing wrong.
  static constexpr std::size_t kMost = 256;

  bool cut(double by_offset, double by_rate, double constant) noexcept;

  std::array<Corner, kMost> corners_{};
  std::size_t count_ = 0;
};

}  // namespace glint::sync
