// SPDX-License-Identifier: MIT
// What a track expects of the exposure that is being matched.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <Eigen/Core>

#include "host/base/ids.hpp"

namespace glint {

/// One way in which a marker may have moved, and where it then is.
struct PredictedMode {
  double weight = 1.0;
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
  bool erratic = false;  ///< anything goes: three views must agree on it where there are three cameras
};

inline constexpr std::size_t kMotionModes = 5;

/// Where a camera shows a marker, other than its calibration says: errors of the calibration, which change
/// slowly with the marker's place.
struct ViewBias {
  Eigen::Vector2d px = Eigen::Vector2d::Zero();  ///< undistorted pixels, shown minus calculated
  double variance_px2 = 0.0;                     ///< per axis
};

/// Where a track expects its marker at the exposure that is being matched.
struct Prediction {
  TrackId track{};
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();  ///< mean over the modes
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();  ///< of all modes together
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();
  std::array<PredictedMode, kMotionModes> modes{};
  std::uint32_t mode_count = 0;      ///< 0: one mode, the two above
  std::span<const ViewBias> bias{};  ///< by camera, borrowed until the match; empty: not known
  double brightness = 1.0;           ///< of the marker, in units of what is usual for a camera
  bool single_view = false;          ///< known well enough that one camera may claim a blob for it
};

}  // namespace glint
