// SPDX-License-Identifier: MIT
// What a camera sees without markers: fixed pattern, ambient light, static reflections, dark noise.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/sim/random.hpp"
#include "host/sim/scene.hpp"

namespace glint::sim {

/// Noise of one pixel: shot noise of the light above the black level, read noise, requested extra noise.
struct NoiseModel {
  explicit NoiseModel(const SimOptions& options);
  float black_grey = 0.0f;
  float grey_per_electron = 0.0f;
  float dark_variance_grey2 = 0.0f;
  /// Variance before rounding of a pixel whose mean is `mean_grey`.
  float variance_grey2(float mean_grey) const noexcept {
    const float light = mean_grey > black_grey ? mean_grey - black_grey : 0.0f;
    return light * grey_per_electron + dark_variance_grey2;
  }
};

/// A pixel of 8 bits: rounded, saturated.
inline std::uint8_t to_pixel(float grey) noexcept {
  const float rounded = grey + 0.5f;
  return static_cast<std::uint8_t>(rounded < 0.0f ? 0.0f : (rounded > 255.0f ? 255.0f : rounded));
}

/// The scene of one camera without markers, and some frames of it with noise, rendered once. A live frame is
/// put together from horizontal stripes of these; every kHoldTicks one stripe after the other is changed for
/// another, so a frame buffer that is used again needs little copying. Where there is a marker, noise is
/// drawn anew.
class Backdrop {
 public:
  static constexpr std::uint32_t kFrames = 4;
  static constexpr std::uint32_t kStripes = 16;
  static constexpr std::uint32_t kHoldTicks = 16;

  Backdrop(const Scene& scene, std::uint32_t camera, const NoiseModel& noise, const NormalTable& normal);

  /// Which noise frame a stripe of that tick's image shows.
  std::uint8_t frame_of(std::uint64_t tick, std::uint32_t stripe) const noexcept {
    return static_cast<std::uint8_t>(
        stream_seed(seed_, Stream::DarkNoise, (tick + stripe) / kHoldTicks, stripe) % kFrames);
  }
  std::uint32_t stripe_rows() const noexcept { return stripe_rows_; }
  const std::uint8_t* row(std::uint8_t frame, std::uint32_t y) const noexcept {
    return frames_[frame].data() + std::size_t{y} * width_;
  }
  /// Mean grey of a row's pixels, in units of kMeanStep.
  static constexpr float kMeanStep = 1.0f / 128.0f;
  const std::uint16_t* mean_row(std::uint32_t y) const noexcept {
    return mean_.data() + std::size_t{y} * width_;
  }

 private:
  void paint_spots(const Scene& scene, std::uint32_t camera, std::vector<float>& mean) const;

  std::uint32_t width_ = 0, height_ = 0, stripe_rows_ = 0;
  std::uint64_t seed_ = 0;
  std::vector<std::uint16_t> mean_;
  std::array<std::vector<std::uint8_t>, kFrames> frames_;
};

}  // namespace glint::sim
