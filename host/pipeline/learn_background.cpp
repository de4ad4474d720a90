// SPDX-License-Identifier: MIT
// Reads frames and learns; before the loop.
#include "host/pipeline/learn_background.hpp"

#include <algorithm>

#include "gpu/background.hpp"
#include "host/base/error.hpp"

namespace glint {

LearntLimits learn_limits(FrameSource& source, std::size_t frames, unsigned margin) {
  std::vector<FrameSize> sizes;
  for (const SourceCamera& camera : source.cameras()) sizes.push_back(camera.size);
  FramePool pool(sizes, 2);
  std::vector<gpu::BackgroundLearner> learners(sizes.size());
  for (std::size_t n = 0; n < frames; ++n) {
    FrameSet set;
    if (source.read(pool, set) != ReadStatus::Ok) break;
    for (std::size_t i = 0; i < learners.size(); ++i) {
      if (set.frames[i] && !set.frames[i]->damaged) learners[i].add(set.frames[i]->image());
    }
  }
  LearntLimits learnt;
  learnt.frames = frames;
  for (std::size_t i = 0; i < learners.size(); ++i) {
    if (learners[i].frames() == 0) {
      throw Error("no frame of camera " + source.cameras()[i].name + " to learn the background from" +
                  (source.problem().empty() ? "" : ": " + source.problem()));
    }
    learnt.frames = std::min(learnt.frames, learners[i].frames());
    learnt.limit_of_camera.push_back(learners[i].limit(margin));
  }
  return learnt;
}

}  // namespace glint
