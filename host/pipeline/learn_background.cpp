// SPDX-License-Identifier: MIT
// Reads frames and learns; before the loop.
#include "host/pipeline/learn_background.hpp"

#include <algorithm>
#include <chrono>
#include <string>

#include "gpu/background.hpp"
#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr std::chrono::seconds kLongestSilence{5};

/// Takes the source off a pool, however this ends.
class LetGo {
 public:
  explicit LetGo(FrameSource& source) : source_(source) {}
  ~LetGo() { source_.let_go(); }
  LetGo(const LetGo&) = delete;
  LetGo& operator=(const LetGo&) = delete;

 private:
  FrameSource& source_;
};

std::string nothing_comes(const FrameSource& source) {
  return "no frames for " + std::to_string(kLongestSilence.count()) +
         " s while the background was to be learnt: are the cameras triggered?" +
         (source.problem().empty() ? "" : "\n" + source.problem());
}

}  // namespace

LearntBackgrounds learn_backgrounds(FrameSource& source, std::size_t frames, unsigned margin) {
  std::vector<FrameSize> sizes;
  for (const SourceCamera& camera : source.cameras()) sizes.push_back(camera.size);
  FramePool pool(sizes, 2 + source.frames_ahead());
  const LetGo let_go(source);
  std::vector<gpu::BackgroundLearner> learners(sizes.size());
  auto give_up = std::chrono::steady_clock::now() + kLongestSilence;
  for (std::size_t n = 0; n < frames; ++n) {
    FrameSet set;
    ReadStatus status = ReadStatus::Idle;
    while ((status = source.read(pool, set)) == ReadStatus::Idle) {
      if (std::chrono::steady_clock::now() > give_up) throw Error(nothing_comes(source));
    }
    if (status != ReadStatus::Ok) break;
    give_up = std::chrono::steady_clock::now() + kLongestSilence;
    for (std::size_t i = 0; i < learners.size(); ++i) {
      if (set.frames[i] && !set.frames[i]->damaged) learners[i].add(set.frames[i]->image());
    }
  }
  LearntBackgrounds learnt;
  learnt.frames = frames;
  for (std::size_t i = 0; i < learners.size(); ++i) {
    if (learners[i].frames() == 0) {
      throw Error("no frame of camera " + source.cameras()[i].name + " to learn the background from" +
                  (source.problem().empty() ? "" : ": " + source.problem()));
    }
    learnt.frames = std::min(learnt.frames, learners[i].frames());
    learnt.cameras.push_back(learners[i].learn(margin));
  }
  return learnt;
}

}  // namespace glint
