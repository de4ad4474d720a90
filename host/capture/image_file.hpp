// SPDX-License-Identifier: MIT
// Single image files: reading to grey, writing grey and colour.
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "gpu/detector.hpp"

namespace glint {

/// Rows without gaps.
struct GreyImage {
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> pixels;
  gpu::ImageView view() const noexcept {
    return {pixels.data(), width_px, height_px, width_px, gpu::PixelFormat::Grey8};
  }
};

/// PGM, PPM, PNG, TIFF, JPEG or BMP, told apart by content; colour becomes luma, deeper images are scaled to
/// 8 bits. Throws Error naming the file.
GreyImage read_grey_image(const std::filesystem::path& path);

// The writers throw Error with the path and the system's reason, and leave no partial file behind. PNG is
// made by FFmpeg's encoder and not libpng: the module reads with FFmpeg already, so this is no further
// dependency.

void write_png_grey(const std::filesystem::path& path, const gpu::ImageView& image);
/// `rgb` holds width_px * height_px * 3 bytes, rows without gaps.
void write_png_rgb(const std::filesystem::path& path, std::uint32_t width_px, std::uint32_t height_px,
                   std::span<const std::uint8_t> rgb);
void write_pgm(const std::filesystem::path& path, const gpu::ImageView& image);

}  // namespace glint
