// SPDX-License-Identifier: MIT
// The limit image: what a pixel must exceed to be bright.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/detector.hpp"

namespace glint::gpu {

/// Collects frames of one camera and gives background + margin, the background being the median over
/// time, so that what moves leaves no hole and what stands still (lamps, reflections) is masked.
class BackgroundLearner {
 public:
  /// Copies the frame. Throws Error if its size differs from the first one's.
  void add(const ImageView& frame);
  std::size_t frames() const noexcept { return frames_.size(); }
  /// width*height bytes: min(255, median + margin); an even number of frames takes the mean of the
  /// middle two, rounded down. Throws Error without frames.
  std::vector<std::uint8_t> limit(unsigned margin) const;
  /// width*height values in steps of 1 / kBackgroundStepsPerGrey: of each pixel the mean over the frames in
  /// which it is within `margin` of its median. Throws Error without frames.
  std::vector<std::uint16_t> mean(unsigned margin) const;

 private:
  std::vector<std::uint8_t> median() const;

  std::uint32_t width_px_ = 0, height_px_ = 0;
  std::vector<std::vector<std::uint8_t>> frames_;
};

/// The limit image without a background: `threshold` everywhere.
std::vector<std::uint8_t> flat_limit(std::uint32_t width_px, std::uint32_t height_px, unsigned threshold);

}  // namespace glint::gpu
