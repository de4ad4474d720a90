// SPDX-License-Identifier: MIT
// Rows on cache lines, and the least limit of every few pixels.
#include "gpu/cpu/limit_image.hpp"

#include <algorithm>

namespace glint::gpu {

LimitImage::LimitImage(std::uint32_t width_px, std::uint32_t height_px)
    : width_px_(width_px),
      height_px_(height_px),
      lines_per_row_(position_stride(width_px) / sizeof(CacheLine)),
      coarse_stride_((std::size_t{width_px} + kCoarsePixels - 1) / kCoarsePixels),
      lines_(lines_per_row_ * height_px),
      coarse_(coarse_stride_ * height_px, std::uint8_t{255}) {
  for (CacheLine& line : lines_) std::fill(std::begin(line.bytes), std::end(line.bytes), std::uint8_t{255});
}

void LimitImage::set(std::span<const std::uint8_t> values) {
  for (std::size_t y = 0; y < height_px_; ++y) {
    const auto row = values.subspan(y * width_px_, width_px_);
    for (std::size_t x = 0; x < width_px_; ++x) {
      lines_[y * lines_per_row_ + x / sizeof(CacheLine)].bytes[x % sizeof(CacheLine)] = row[x];
    }
    for (std::size_t c = 0; c < coarse_stride_; ++c) {
      const std::size_t begin = c * kCoarsePixels;
      const auto part = row.subspan(begin, std::min<std::size_t>(kCoarsePixels, width_px_ - begin));
      coarse_[y * coarse_stride_ + c] = *std::min_element(part.begin(), part.end());
    }
  }
}

Rows LimitImage::rows(const ImageView& image) const noexcept {
  return {image.pixels, lines_.front().bytes, coarse_.data(), image.stride_bytes, coarse_stride_, width_px_};
}

}  // namespace glint::gpu
