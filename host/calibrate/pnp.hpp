// SPDX-License-Identifier: MIT
// Where a known target stands before a calibrated camera, from its points in one image.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint {

struct TargetPose {
  Pose camera_from_target;
  double rms_px = 0.0;  ///< of the reprojection, per point: sqrt(mean |measured - predicted|^2)
};

/// The poses that explain the image, best first. Of a plane that is small or far there are two, which differ
/// in the sign of its tilt towards the camera (Schweighofer and Pinz, PAMI 28(12), 2006): both are found and
/// refined, and only the rms tells them apart. Points of a plane: four or more, no three of four on a line.
/// Other points: six or more. Points whose pixel the lens model cannot undo are left out. Empty if there is
/// no solution in front of the camera. The calibration's own pose is not looked at.
std::vector<TargetPose> target_poses(const CameraCalibration& camera,
                                     std::span<const Eigen::Vector3d> points_in_target,
                                     std::span<const Eigen::Vector2d> pixels);

/// The best of them.
std::optional<Pose> camera_from_target(const CameraCalibration& camera,
                                       std::span<const Eigen::Vector3d> points_in_target,
                                       std::span<const Eigen::Vector2d> pixels);

}  // namespace glint
