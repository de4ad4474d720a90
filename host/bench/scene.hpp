// SPDX-License-Identifier: MIT
// The pictures that every contender gets: a dim room, lamps, sensor noise, and round markers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "gpu/detector.hpp"

namespace glint::bench {

struct SceneOptions {
  unsigned cameras = 4;
  std::uint32_t width_px = 1280, height_px = 800;
  unsigned blobs_per_camera = 20;
  unsigned ticks = 4;                         ///< different frame sets, shown in rotation
  unsigned margin = 40;                       ///< limit = background + margin
  double noise_grey = 1.2;                    ///< standard deviation of the sensor noise, grey levels
  unsigned drawn_cameras = gpu::kMaxCameras;  ///< camera i shows a copy of camera i % drawn_cameras
  std::uint64_t seed = 1;
};

/// The same pictures for the same options on every machine. Background 8 to 14 grey levels with a fixed
/// pattern, five reflections per camera that stand still, noise, anti-aliased discs of 3 to 40 px diameter
/// that do not touch. Each camera has memory of its own, also where it shows a copy.
class Scene {
 public:
  /// Throws Error if a picture is under 64x64 px or cannot hold so many discs.
  explicit Scene(const SceneOptions& options);

  const SceneOptions& options() const noexcept { return options_; }
  /// How many cameras have pictures of their own.
  unsigned drawn_cameras() const noexcept { return drawn_; }
  /// All frames in one page-aligned piece, for Detector::adopt_frame_memory().
  std::span<std::byte> memory() noexcept { return {memory_.get(), memory_bytes_}; }
  std::span<const std::uint8_t> background(unsigned camera) const noexcept {
    return backgrounds_[camera % drawn_];
  }
  std::span<const std::uint8_t> limit(unsigned camera) const noexcept { return limits_[camera % drawn_]; }

  /// Rows begin at multiples of 16 bytes, and below each picture there is room up to a multiple of 8 rows: so
  /// live capture lays its frames, and so devices can read them in place.
  std::uint32_t stride_bytes() const noexcept { return stride_bytes_; }
  std::uint8_t* pixels(unsigned tick, unsigned camera) const noexcept;
  /// One image per camera; the pixels stay the scene's.
  std::vector<gpu::ImageView> images(unsigned tick) const;
  /// A wide lens, whose model can be inverted everywhere in the image.
  std::vector<gpu::CameraFormat> formats() const;

 private:
  struct Free {
    void operator()(std::byte* memory) const noexcept;
  };

  std::uint64_t next() noexcept;
  double uniform(double from, double to) noexcept;
  void make_noise_table();
  std::vector<float> make_room();
  void add_disc(std::vector<float>& image, double x, double y, double diameter, double brightness) const;
  void draw(unsigned tick, unsigned camera, const std::vector<float>& room);

  SceneOptions options_;
  unsigned drawn_;
  std::uint32_t stride_bytes_;
  std::size_t frame_bytes_, memory_bytes_;
  std::unique_ptr<std::byte, Free> memory_;
  std::uint64_t random_;
  std::vector<float> noise_;
  std::vector<std::vector<std::uint8_t>> backgrounds_, limits_;
};

}  // namespace glint::bench
