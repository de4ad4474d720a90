// SPDX-License-Identifier: MIT
// The limit image of a camera, laid out for the row kernels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gpu/cpu/row_kernels.hpp"

namespace glint::gpu {

class LimitImage {
 public:
  /// 255 everywhere: nothing is bright.
  LimitImage(std::uint32_t width_px, std::uint32_t height_px);
  /// values: width_px * height_px bytes.
  void set(std::span<const std::uint8_t> values);
  /// An image of this size together with its limits.
  Rows rows(const ImageView& image) const noexcept;

 private:
  struct alignas(64) CacheLine {
    std::uint8_t bytes[64];
  };
  std::uint32_t width_px_, height_px_;
  std::size_t lines_per_row_, coarse_stride_;
  std::vector<CacheLine> lines_;
  std::vector<std::uint8_t> coarse_;
};

}  // namespace glint::gpu
