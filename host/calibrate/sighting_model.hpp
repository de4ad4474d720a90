// SPDX-License-Identifier: MIT
// Where a camera sees a point, and how that changes with the point and with the camera.
#pragma once

#include <array>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint {

/// fx fy cx cy k1 k2 p1 p2 k3, in pixels and OpenCV's units.
using Intrinsics = std::array<double, 9>;

Intrinsics intrinsics_of(const CameraCalibration& camera);
void set_intrinsics(CameraCalibration& camera, const Intrinsics& intrinsics);

struct PredictedSighting {
  Eigen::Vector2d pixel;  ///< raw image
  Eigen::Matrix<double, 2, 3> by_point_in_camera;
  Eigen::Matrix<double, 2, 9> by_intrinsics;
};

/// The centre of the outline of a sphere of that radius (0: the point itself). False if the point does not
/// lie in front of the camera; `predicted` is then not changed.
bool predict_sighting(const double* intrinsics, const Eigen::Vector3d& point_in_camera,
                      double marker_radius_m, PredictedSighting& predicted) noexcept;

}  // namespace glint
