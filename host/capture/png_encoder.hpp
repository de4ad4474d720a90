// SPDX-License-Identifier: MIT
// PNG files in memory. Free of FFmpeg's headers.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace glint {

/// `channels` is 1 (grey) or 3 (red, green, blue); rows without gaps. Throws Error if FFmpeg cannot.
std::vector<std::uint8_t> encode_png(std::uint32_t width_px, std::uint32_t height_px, unsigned channels,
                                     std::span<const std::uint8_t> pixels);

}  // namespace glint
