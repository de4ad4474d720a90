// SPDX-License-Identifier: MIT
// What part of the world a report's pictures show.
#pragma once

#include <span>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint {

struct ReportExtent {
  Eigen::Vector3d low_in_world = Eigen::Vector3d::Zero(), high_in_world = Eigen::Vector3d::Ones();
  Eigen::Vector3d middle_in_world = Eigen::Vector3d::Constant(0.5);  ///< median of the samples, axis by axis
};

/// Holds all cameras, the samples but for stray ones, and the floor where it is near.
ReportExtent report_extent(const Calibration& calibration, std::span<const Eigen::Vector3d> samples_in_world);

}  // namespace glint
