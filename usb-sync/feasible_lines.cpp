// SPDX-License-Identifier: MIT
#include "usb-sync/feasible_lines.hpp"

#include <algorithm>
#include <limits>

namespace glint::sync {

void FeasibleLines::start(Range offset, Range rate) noexcept {
  corners_[0] = {offset.least, rate.least};
  corners_[1] = {offset.most, rate.least};
  corners_[2] = {offset.most, rate.most};
  corners_[3] = {offset.least, rate.most};
  count_ = 4;
}

/// Keeps the half-plane by_offset * offset + by_rate * rate + constant >= 0 (Sutherland and Hodgman 1974).
bool FeasibleLines::cut(double by_offset, double by_rate, double constant) noexcept {
  const auto inside = [=](const Corner& c) { return by_offset * c.offset + by_rate * c.rate + constant; };
  std::array<double, kMost> distance;
  std::size_t outside = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    distance[i] = inside(corners_[i]);
    if (distance[i] < 0.0) ++outside;
  }
  if (outside == 0) return true;
  if (outside == count_) return false;

  std::array<Corner, kMost> kept;
  std::size_t count = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const std::size_t next = i + 1 < count_ ? i + 1 : 0;
    const double here = distance[i], there = distance[next];
    if (count + 2 > kMost) return true;
    if (here >= 0.0) kept[count++] = corners_[i];
    if ((here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0)) {
      const double share = here / (here - there);
      kept[count++] = {corners_[i].offset + share * (corners_[next].offset - corners_[i].offset),
                       corners_[i].rate + share * (corners_[next].rate - corners_[i].rate)};
    }
  }
  if (count < 3) return false;
  std::copy_n(kept.begin(), count, corners_.begin());
  count_ = count;
  return true;
}

FeasibleLines::Range FeasibleLines::at(double x) const noexcept {
  Range range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < count_; ++i) {
    const double y = corners_[i].offset + corners_[i].rate * x;
    range.least = std::min(range.least, y);
    range.most = std::max(range.most, y);
  }
  return range;
}

FeasibleLines::Range FeasibleLines::rate() const noexcept {
  const auto [least, most] =
      std::minmax_element(corners_.begin(), corners_.begin() + static_cast<std::ptrdiff_t>(count_),
                          [](const Corner& one, const Corner& other) { return one.rate < other.rate; });
  return {least->rate, most->rate};
}

}  // namespace glint::sync
