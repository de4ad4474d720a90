// SPDX-License-Identifier: MIT
// Images of the simulated cameras. Only where there is light is anything computed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/sim/backdrop.hpp"
#include "host/sim/marker_painter.hpp"
#include "host/sim/scene.hpp"

namespace glint::sim {

/// Part of an image, inclusive.
struct PixelBox {
  int x_min_px = 0, y_min_px = 0, x_max_px = -1, y_max_px = -1;
};

/// What was drawn into one frame buffer last time, so that only that need be undone.
struct BufferMemory {
  static constexpr std::uint8_t kUnknown = 255;
  BufferMemory() { stripe.fill(kUnknown); }
  std::uint32_t backdrop = 0;                           ///< camera that took what it holds
  std::array<std::uint8_t, Backdrop::kStripes> stripe;  ///< noise frame shown by each stripe
  std::vector<PixelBox> drawn;                          ///< boxes that hold markers and blinks
};

/// Thread-bound. The image of (camera, tick) depends on nothing else, whatever buffer it goes to.
class Renderer {
 public:
  explicit Renderer(const Scene& scene);

  /// Draws height rows of `stride_bytes` at `pixels`. `memory` belongs to that buffer; a fresh one forces
  /// full drawing. If something else wrote to the buffer in between, `memory` must be made anew.
  void render(std::uint32_t camera, std::uint64_t tick, std::uint8_t* pixels, std::uint32_t stride_bytes,
              BufferMemory& memory);

  /// The noiseless light of all markers of one camera, row by row in grey levels, for tests.
  std::vector<float> light(std::uint32_t camera, std::uint64_t tick);
  const NoiseModel& noise() const noexcept { return noise_; }

 private:
  void restore(const Backdrop& backdrop, std::uint64_t tick, std::uint8_t* pixels, std::uint32_t stride_bytes,
               BufferMemory& memory) const;
  void collect_light(std::uint32_t camera, std::uint64_t tick, std::vector<PixelBox>& boxes);
  void add_blinks(std::uint32_t camera, std::uint64_t tick, std::uint8_t* pixels, std::uint32_t stride_bytes,
                  std::vector<PixelBox>& boxes) const;
  void merge_overlapping(std::vector<PixelBox>& boxes) const;

  const Scene& scene_;
  NoiseModel noise_;
  NormalTable normal_;
  std::vector<Backdrop> backdrops_;
  MarkerPainter painter_;
  std::vector<MarkerView> views_;
  std::vector<float> light_;  // grey added by markers, one image; all zero between calls
};

}  // namespace glint::sim
