// SPDX-License-Identifier: MIT
// Bundle adjustment: cameras and target moved until all sightings fit best (Triggs et al., Bundle Adjustment
// - A Modern Synthesis, 2000).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/sighting_model.hpp"
#include "host/geometry/pose.hpp"
#include "host/target/target.hpp"

namespace glint {

struct BundleCamera {
  Intrinsics intrinsics{};
  Intrinsics intrinsics_sd{};  ///< how well they are known beforehand; 0: that one is not changed
  Pose camera_from_world;
  bool pose_fixed = false;
};

/// Where the target is at one tick. A board is rigid: its pose. The markers of a wand are free points, held
/// together by their known distances, since real wands bend and are not quite straight; the column of a
/// marker is its number.
struct BundleTick {
  Pose world_from_target;            ///< of a board
  Eigen::Matrix3Xd points_in_world;  ///< of a marker or a wand
};

struct BundleSighting {
  std::uint32_t camera = 0, tick = 0,
                point = 0;  ///< indices into Bundle::cameras, ::ticks, Target::points_in_target
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

struct Bundle {
  Target target;
  std::vector<BundleCamera> cameras;
  std::vector<BundleTick> ticks;
  std::vector<BundleSighting> sightings;  ///< each marker of a wand by two cameras at least
};

struct BundleOptions {
  double sigma_px = 0.3;        ///< expected standard deviation, per axis, of a sighting
  double length_sd_m = 0.0002;  ///< of a wand's distances: how far it bends
  bool robust = true;           ///< sightings beyond three standard deviations count less (Cauchy)
  bool refine_intrinsics = false;
  /// False: only a marker; the distance of the first two cameras is kept, the first of which must stand at
  /// the origin.
  bool scale_known = true;
  bool schur = true;  ///< eliminate the target first; false: what Ceres does by default (for comparison)
  int max_steps = 100;
};

struct BundleSummary {
  bool converged = false;
  int steps = 0;
  double seconds = 0.0;
  std::string message;  ///< what the solver said
};

/// Moves `bundle` to the minimum. Where no camera's pose is fixed, the first one stays: that is the gauge.
/// Every point must lie in front of the cameras that saw it. On one thread,
/// so that the same bundle gives the same result to the last digit. Throws Error if the solver cannot even
/// begin.
BundleSummary adjust(Bundle& bundle, const BundleOptions& options);

}  // namespace glint
