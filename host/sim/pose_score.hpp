// SPDX-License-Identifier: MIT
// How good a tracker's poses of rigid bodies are, against the truth.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/sim/scene.hpp"

namespace glint {

/// One pose of a tracker's output.
struct ScoredPose {
  std::uint32_t name = 0;  ///< as the tracker has it: 0, 1, ..., fewer than there are bodies in the scene
  Pose world_from_body;
  bool measured = true;    ///< false: only predicted
  bool ambiguous = false;  ///< the tracker says that it may be another body, or turned otherwise
};

/// Ratios are 0 where nothing was counted.
struct PoseResult {
  std::uint64_t ticks = 0, poses = 0, ambiguous = 0;  ///< poses: measured ones only
  std::uint64_t expected = 0;  ///< bodies with three markers or more visible in two delivered frames
  std::uint64_t found = 0;     ///< of those, with a measured pose
  std::uint64_t astray = 0;    ///< measured poses at no body
  /// A name, not said to be ambiguous, that is at another body than when it was last sure.
  std::uint64_t silent_swaps = 0;
  double recall = 0.0;
  double rms_m = 0.0, max_m = 0.0;      ///< of the origin, of all measured poses that are at a body
  double rms_rad = 0.0, max_rad = 0.0;  ///< angle of the turn between pose and truth, of the same
};

/// A pose belongs to the body whose origin is nearest, within `gate_m`. Which name is which of several
/// identical bodies is the tracker's choice when it first is sure. Thread-bound; no allocation once the first
/// tick was seen.
class PoseScore {
 public:
  /// `scene` must outlive the score.
  explicit PoseScore(const Scene& scene, double gate_m = 0.03);
  /// Of every tick in which the light was on, in order.
  void add(std::uint64_t tick, std::span<const ScoredPose> poses);
  PoseResult result() const;

 private:
  std::uint32_t nearest_body(const Eigen::Vector3d& origin) const noexcept;

  const Scene& scene_;
  double gate_m_;
  TickTruth truth_;
  std::vector<std::uint32_t> body_of_name_;  // when it was last sure
  std::vector<std::uint8_t> found_;          // by body, in this tick
  PoseResult counts_;
  double sum_error2_m2_ = 0.0, sum_error2_rad2_ = 0.0;
};

}  // namespace glint
