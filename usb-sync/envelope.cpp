// SPDX-License-Identifier: MIT
#include "usb-sync/envelope.hpp"

#include <algorithm>

namespace glint::sync {

void Envelope::add(Point point) noexcept {
  std::size_t at = count_;
  while (at > 0 && points_[at - 1].x > point.x) --at;
  if (at > 0 && points_[at - 1].x == point.x) {
    if (side_ * (points_[at - 1].y - point.y) <= 0.0) return;
    erase(--at);
  }
  if (at > 0 && at < count_ && !matters(points_[at - 1], point, points_[at])) return;

  const auto begin = points_.begin();
  std::move_backward(begin + static_cast<std::ptrdiff_t>(at), begin + static_cast<std::ptrdiff_t>(count_),
                     begin + static_cast<std::ptrdiff_t>(count_) + 1);
  points_[at] = point;
  ++count_;
  while (at >= 2 && !matters(points_[at - 2], points_[at - 1], points_[at])) erase(--at);
  while (at + 2 < count_ && !matters(points_[at], points_[at + 1], points_[at + 2])) erase(at + 1);
  if (count_ > kMost) erase(0);
}

/// Seen from its own x, it is beyond the line through the lifted neighbours.
bool Envelope::matters(const Point& before, const Point& point, const Point& after) const noexcept {
  const auto lifted = [this, &point](const Point& other) {
    const double x = other.x - point.x;
    return side_ * (other.y - point.y) + 0.5 * max_bend_ * x * x;
  };
  const double to_before = point.x - before.x, to_after = after.x - point.x;
  return lifted(before) * to_after + lifted(after) * to_before > 0.0;
}

void Envelope::erase(std::size_t index) noexcept {
  const auto begin = points_.begin();
  std::move(begin + static_cast<std::ptrdiff_t>(index) + 1, begin + static_cast<std::ptrdiff_t>(count_),
            begin + static_cast<std::ptrdiff_t>(index));
  --count_;
}

}  // namespace glint::sync
