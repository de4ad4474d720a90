// SPDX-License-Identifier: MIT
// Counts blobs for the alignment.
#include "host/pipeline/coded_light.hpp"

#include <array>

namespace glint {

void check_light(CodeAlignment& alignment, const FrameSet& set, TickBlobs& tick) noexcept {
  std::array<SeenLight, gpu::kMaxCameras> seen{};
  const std::size_t cameras = tick.cameras.size();
  for (std::size_t n = 0; n < cameras; ++n) {
    if (!set.frames[n]) continue;
    seen[n] = {true, static_cast<std::uint32_t>(tick.cameras[n].size()), set.frames[n]->run,
               set.frames[n]->shifted};
  }
  alignment.add(number(set.trigger), set.exposed, std::span(seen.data(), cameras));
  tick.unproven = alignment.unproven();
  tick.dark = set.dark || alignment.dark(number(set.trigger));
  tick.events = alignment.events();
}

}  // namespace glint
