// SPDX-License-Identifier: MIT
// Where one camera sees a point whose height is known: planar tracking from the ceiling.
#pragma once

#include <optional>

#include <Eigen/Core>

#include "host/geometry/triangulate.hpp"

namespace glint {

/// A ray that meets the plane at less than this (5 degrees) runs along it: a pixel would be a dozen times as
/// long there as it is wide.
inline constexpr double kLeastFloorAngle_rad = 0.0873;

struct FloorPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< from the observation's and the height's
};

/// The point of the ray of `view` at the world height `height_m`, known to `height_sd_m`. A marker off the
/// floor hides floor that is farther away: without its height, x and y would be off by height * tan(angle
/// from the vertical). With a radius the blob is a sphere's outline, and its centre is what lies at that
/// height. Nothing if the camera does not look at the plane there, or along it.
std::optional<FloorPoint> floor_point(const Observation& view, double height_m, double marker_radius_m,
                                      double height_sd_m = 0.0) noexcept;

enum class PlaneSight { Seen, Behind, EdgeOn };

/// Whether any part of the image looks at the plane at that height, and if none does, why not.
PlaneSight sight_of_plane(const Camera& camera, double height_m) noexcept;

}  // namespace glint
