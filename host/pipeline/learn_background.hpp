// SPDX-License-Identifier: MIT
// What the cameras show without markers, from the first frames of a source.
#pragma once

#include <cstddef>
#include <vector>

#include "gpu/background.hpp"
#include "host/frames/source.hpp"

namespace glint {

struct LearntBackgrounds {
  std::vector<gpu::Background> cameras;
  std::size_t frames = 0;  ///< learnt from, of the camera that gave fewest
};

/// Reads up to `frames` sets, which the source then lacks; `margin` grey levels above its background a pixel
/// is bright. Throws Error when a camera gave none, or none gave any for 5 s.
LearntBackgrounds learn_backgrounds(FrameSource& source, std::size_t frames, unsigned margin);

}  // namespace glint
