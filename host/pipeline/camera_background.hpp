// SPDX-License-Identifier: MIT
// What one camera shows without markers.
#pragma once

#include <cstdint>
#include <vector>

#include "gpu/background.hpp"

namespace glint {

/// Rows without gaps, of the camera's size.
struct CameraBackground {
  std::vector<std::uint8_t> limit;  ///< what a pixel must exceed to be bright
  std::vector<std::uint16_t> mean;  ///< see gpu::ImageView::background; empty: not known

  static CameraBackground of(const gpu::BackgroundLearner& learner, unsigned margin) {
    return {learner.limit(margin), learner.mean(margin)};
  }
};

}  // namespace glint
