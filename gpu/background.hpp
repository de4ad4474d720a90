// SPDX-License-Identifier: MIT
// What a camera shows without markers, and the limit image: what a pixel must exceed to be bright.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/detector.hpp"

namespace glint::gpu {

/// Of one camera, width*height values each.
struct Background {
  std::vector<std::uint8_t> limit;  ///< min(255, median over time + margin)
  /// In steps of 1 / kBackgroundStepsPerGrey, for ImageView::background: of each pixel the mean over the
  /// frames in which it is within the margin of its median. Empty: not known.
  std::vector<std::uint16_t> mean;
};

/// Collects frames of one camera. Medians over time: what moves leaves no hole, and what stands still (lamps,
/// reflections) is masked.
class BackgroundLearner {
 public:
  /// Copies the frame. Throws Error if its size differs from the first one's.
  void add(const ImageView& frame);
  std::size_t frames() const noexcept { return frames_.size(); }
  /// The median of an even number of frames is the mean of the middle two, rounded down. Throws Error without
  /// frames.
  Background learn(unsigned margin) const;

 private:
  std::vector<std::uint8_t> median() const;
  std::vector<std::uint16_t> mean_near(const std::vector<std::uint8_t>& middle, unsigned margin) const;

  std::uint32_t width_px_ = 0, height_px_ = 0;
  std::vector<std::vector<std::uint8_t>> frames_;
};

/// The limit image without a background: `threshold` everywhere.
std::vector<std::uint8_t> flat_limit(std::uint32_t width_px, std::uint32_t height_px, unsigned threshold);

}  // namespace glint::gpu
