// SPDX-License-Identifier: MIT
// Of many inequalities of one direction, those that matter.
#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace glint::sync {

/// The curve passes below (Side::Above: above) each of these points; it is smooth: its slope changes by at
/// most max_bend per x. Seen from any x0, the tangent there passes below the point lifted by max_bend / 2 *
/// (x - x0)^2. Lifting by parabolas about different x0 differs by a straight line only, which does not change
/// what is on the convex hull: so one hull serves every x0, and points inside it are dropped for good. Keeps
/// the newest kMost corners. No allocation; adding a newest point takes constant time on average.
class Envelope {
 public:
  enum class Side : signed char { Below = 1, Above = -1 };
  struct Point {
    double x = 0.0, y = 0.0;
  };
  static constexpr std::size_t kMost = 64;

  Envelope(Side side, double max_bend) noexcept : side_(static_cast<double>(side)), max_bend_(max_bend) {}

  void clear() noexcept { count_ = 0; }
  /// Points may come in any order; it is quick where x grows.
  void add(Point point) noexcept;
  /// By x.
  std::span<const Point> points() const noexcept { return {points_.data(), count_}; }

 private:
  bool matters(const Point& before, const Point& point, const Point& after) const noexcept;
  void erase(std::size_t index) noexcept;

  double side_, max_bend_;
  std::size_t count_ = 0;
  std::array<Point, kMost + 1> points_{};
};

}  // namespace glint::sync
