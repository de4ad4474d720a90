// SPDX-License-Identifier: MIT
// Standard deviations of what a calibration says of each camera.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/calibrate/quality.hpp"
#include "host/calibrate/sighting_model.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

struct CameraSd {
  Eigen::Vector3d position_m = Eigen::Vector3d::Zero();  ///< along the world's axes
  double orientation_rad = 0.0;                          ///< root of the mean squared angle
  Intrinsics intrinsics{};                               ///< 0: they were not estimated

  double distance_m() const { return position_m.norm(); }  ///< root of the mean squared distance
};

/// One per camera; none if the covariance is not known.
std::vector<CameraSd> camera_sd(const Calibration& calibration, const CalibrationUncertainty& uncertainty);

}  // namespace glint
