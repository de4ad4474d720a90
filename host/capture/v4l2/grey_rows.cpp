// SPDX-License-Identifier: MIT
// Copies of rows.
#include "host/capture/v4l2/grey_rows.hpp"

#include <cstring>

namespace glint {

void copy_grey_rows(const std::byte* from, const AgreedFormat& format, const GreyTarget& target) noexcept {
  const std::size_t width = target.size.width_px;
  for (std::size_t y = 0; y < target.size.height_px; ++y) {
    const std::byte* const row = from + y * format.stride_bytes;
    std::uint8_t* const pixels = target.pixels + y * target.stride_bytes;
    if (format.kind == PixelKind::Yuyv) {
      for (std::size_t x = 0; x < width; ++x) pixels[x] = std::to_integer<std::uint8_t>(row[2 * x]);
    } else {
      std::memcpy(pixels, row, width);
    }
  }
}

}  // namespace glint
