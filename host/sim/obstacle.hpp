// SPDX-License-Identifier: MIT
// Dark things that stand between markers and cameras.
#pragma once

#include <Eigen/Core>

namespace glint::sim {

/// A dark vertical cylinder that stands on the floor.
struct Pole {
  double x_m = 0.0, y_m = 0.0, radius_m = 0.0, height_m = 0.0;
};

/// A dark rod with round ends; a ball where both ends are one.
struct Capsule {
  Eigen::Vector3d from_in_world, to_in_world;
  double radius_m = 0.0;
};

/// Whether any of the segment between the two points lies inside.
bool blocks(const Pole& pole, const Eigen::Vector3d& from, const Eigen::Vector3d& to) noexcept;
bool blocks(const Capsule& capsule, const Eigen::Vector3d& from, const Eigen::Vector3d& to) noexcept;

}  // namespace glint::sim
