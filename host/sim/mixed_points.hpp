// SPDX-License-Identifier: MIT
// Points that were made from images of different markers.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "gpu/detector.hpp"
#include "host/sim/scene.hpp"

namespace glint::sim {

/// A point is mixed if, of the cameras that it says it used, two or more show some marker where the point
/// would be seen, and no marker is shown there by all of these. "Shown" is a marker some of whose light
/// reaches that camera at that tick (even if half hidden), "where" is within `gate_px` + the radius of its
/// image of the point's projection with the true calibration. A camera that shows nothing there says nothing:
/// what it saw was no marker. Allocates only the first time. Thread-bound.
class MixedPoints {
 public:
  /// `scene` must outlive it.
  explicit MixedPoints(const Scene& scene, double gate_px);

  /// `cameras`: bit set, not empty. `truth` must be of the scene.
  bool mixed(const TickTruth& truth, const Eigen::Vector3d& position_in_world, std::uint32_t cameras);

 private:
  bool shown(const TickTruth& truth, std::uint32_t camera, std::uint32_t marker) const;

  const Scene& scene_;
  double gate_px_;
  std::vector<std::uint32_t> times_shown_;  // per marker
};

}  // namespace glint::sim
