// SPDX-License-Identifier: MIT
// Rigid transform. Named a_from_b: x_in_a = rotation * x_in_b + translation.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace glint {

struct Pose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  Pose inverse() const {
    const Eigen::Quaterniond r = rotation.conjugate();
    return {r, -(r * translation)};
  }
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return rotation * point + translation; }
  Pose operator*(const Pose& b_from_c) const {
    return {(rotation * b_from_c.rotation).normalized(), rotation * b_from_c.translation + translation};
  }
};

}  // namespace glint
