// SPDX-License-Identifier: MIT
// Frames of the simulated rig, rendered beforehand, as a source that gives them again and again.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "host/frames/source.hpp"
#include "host/sim/scene.hpp"

namespace glint {

/// Ticks 0 to length - 1 and back again, so that markers never jump. A frame is copied into the pool as a
/// decoder would write it there; that is all the work that a tick costs.
class FrameLoop final : public FrameSource {
 public:
  /// `scene` is only needed here. live: say so; whoever reads does the pacing.
  FrameLoop(const Scene& scene, std::uint64_t length, std::uint64_t ticks, bool live);

  std::span<const SourceCamera> cameras() const noexcept override { return cameras_; }
  double rate_hz() const noexcept override { return rate_hz_; }
  bool live() const noexcept override { return live_; }
  [[nodiscard]] ReadStatus read(FramePool& pool, FrameSet& set) noexcept override;
  SourceCounters counters() const noexcept override { return counters_; }
  const std::string& problem() const noexcept override { return problem_; }

 private:
  std::vector<SourceCamera> cameras_;
  double rate_hz_;
  std::uint64_t length_, ticks_;
  bool live_;
  std::vector<std::uint8_t> pixels_;  // tick after tick, camera after camera, without padding
  std::uint64_t next_ = 0;
  SourceCounters counters_;
  std::string problem_;
};

}  // namespace glint
