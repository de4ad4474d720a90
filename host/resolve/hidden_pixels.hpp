// SPDX-License-Identifier: MIT
// Pixels of a box that something hides, and their neighbours.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "host/resolve/disc_fit.hpp"

namespace glint {

/// Pixels that are darker than any disc allows, so that something must hide them. Their neighbours are half
/// hidden by the same thing, by too little to be noticed one by one. What one step finds serves
/// the next. Of boxes larger than its room it remembers nothing.
class HiddenPixels {
 public:
  explicit HiddenPixels(const PixelBox& box) noexcept
      : width_(box.x_max_px - box.x_min_px + 3), x_(box.x_min_px - 1), y_(box.y_min_px - 1) {
    const int height = box.y_max_px - box.y_min_px + 3;
    used_ = static_cast<std::size_t>(width_) * static_cast<std::size_t>(height);
    if (used_ > kRoom) used_ = 0;
    for (auto& map : maps_) std::fill_n(map.begin(), used_, std::uint8_t{0});
  }
  void next_step() noexcept {
    now_ ^= 1;
    any_ = found_;
    if (found_) std::fill_n(maps_[now_].begin(), used_, std::uint8_t{0});
    found_ = false;
  }
  void found(int x, int y) noexcept {
    if (used_ == 0) return;
    found_ = true;
    std::uint8_t* at = maps_[now_].data() + (y - y_) * width_ + (x - x_);
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) at[dy * width_ + dx] = 1;
  }
  bool near(int x, int y) const noexcept {
    return any_ && maps_[now_ ^ 1][static_cast<std::size_t>((y - y_) * width_ + (x - x_))] != 0;
  }

 private:
  static constexpr std::size_t kRoom = 100 * 100;
  int width_, x_, y_;
  std::size_t used_;
  bool found_ = false, any_ = false;
  unsigned now_ = 0;
  std::array<std::array<std::uint8_t, kRoom>, 2> maps_;
};

}  // namespace glint
