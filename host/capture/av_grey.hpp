// SPDX-License-Identifier: MIT
// Any decoded picture to full-range 8-bit grey. Only av_*.cpp include this.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/capture/av_handles.hpp"
#include "host/capture/grey_target.hpp"

namespace glint::av {

/// Grey and luma planes are copied exactly (video range is stretched, more than 8 bits are scaled with
/// rounding); palettes and colour become luma with weights that leave grey as it is.
class GreyConverter {
 public:
  /// `frame` must have the size of `target`. False if its pixel format cannot be converted.
  [[nodiscard]] bool convert(const AVFrame& frame, const GreyTarget& target);

 private:
  bool convert_colour(const AVFrame& frame, const GreyTarget& target);
  SwsPtr to_rgb_;
  int rgb_source_format_ = -1, rgb_width_ = 0, rgb_height_ = 0;
  std::vector<std::uint8_t> rgb_;
};

/// More than 8 bits in the grey or luma channel.
bool is_deep(const AVFrame& frame) noexcept;

}  // namespace glint::av
