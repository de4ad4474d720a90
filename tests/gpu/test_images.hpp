// SPDX-License-Identifier: MIT
// Images that labellers get wrong, each with its limit image.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "gpu/detector.hpp"

namespace glint::gpu::testing {

struct TestImage {
  std::string name;
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> pixels, limit;  // width_px * height_px, no padding
};

/// Is pixel (x, y) bright?
using Mask = std::function<bool(std::uint32_t x, std::uint32_t y)>;

/// Bright pixels get values above a random limit, dark ones values up to it.
TestImage image_from_mask(std::string name, std::uint32_t width_px, std::uint32_t height_px, const Mask& mask,
                          std::uint32_t seed);
/// Each pixel bright with this probability.
TestImage noise_image(std::uint32_t width_px, std::uint32_t height_px, double density, std::uint32_t seed);
TestImage all_white(std::uint32_t width_px, std::uint32_t height_px);
TestImage all_black(std::uint32_t width_px, std::uint32_t height_px);
/// Round spots with soft edges over a gradient, `count` of up to `diameter_px`.
TestImage soft_spots(std::uint32_t width_px, std::uint32_t height_px, unsigned count, double diameter_px,
                     std::uint32_t seed);
/// Isolated pixels, two apart: as many blobs as fit.
TestImage dot_grid(std::uint32_t width_px, std::uint32_t height_px);
/// Combs, spirals, rings, checkerboards, diagonals, late merges, borders, corners: at most 32 of this size.
std::vector<TestImage> shape_images(std::uint32_t width_px, std::uint32_t height_px);

/// A wide lens for an image of this size, invertible everywhere in it.
Lens wide_lens(std::uint32_t width_px, std::uint32_t height_px);

std::vector<CameraFormat> formats_of(std::span<const TestImage> images);

/// How images lie in memory: as the GPU likes it, or as badly as allowed. Padding is white.
enum class Layout { Aligned, Unaligned };

/// Page-aligned memory with one image per camera in it.
class FrameMemory {
 public:
  FrameMemory(std::span<const TestImage> images, Layout layout);
  std::span<std::byte> memory() noexcept { return {reinterpret_cast<std::byte*>(memory_.get()), bytes_}; }
  /// Replaces the pixels of a camera's image.
  void write(std::size_t camera, const TestImage& image);
  std::vector<ImageView> views() const { return views_; }

 private:
  std::size_t bytes_ = 0;
  std::unique_ptr<std::uint8_t, decltype(&std::free)> memory_{nullptr, &std::free};
  std::vector<ImageView> views_;
  std::vector<std::size_t> offsets_;
};

}  // namespace glint::gpu::testing
