// SPDX-License-Identifier: MIT
// Limit images from the first frames of a source.
#pragma once

#include <cstdint>
#include <vector>

#include "host/frames/source.hpp"

namespace glint {

struct LearntLimits {
  std::vector<std::vector<std::uint8_t>> limit_of_camera;
  std::size_t frames = 0;  ///< learnt from, of the camera that gave fewest
};

/// Reads up to `frames` sets, which the source then lacks: median over time + margin. Throws Error when a
/// camera gave none, or none gave any for 5 s.
LearntLimits learn_limits(FrameSource& source, std::size_t frames, unsigned margin);

}  // namespace glint
