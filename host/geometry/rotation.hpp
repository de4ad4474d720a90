// SPDX-License-Identifier: MIT
// Rotation vectors: axis times angle, in radians.
#pragma once

#include <cmath>

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace glint {

/// cross_matrix(a) * b is a x b.
inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& a) noexcept {
  Eigen::Matrix3d m;
  m << 0.0, -a.z(), a.y(), a.z(), 0.0, -a.x(), -a.y(), a.x(), 0.0;
  return m;
}

inline Eigen::Quaterniond rotation_of(const Eigen::Vector3d& vector) noexcept {
  const double angle = vector.norm();
  const double scale = angle < 1e-8 ? 0.5 : std::sin(0.5 * angle) / angle;
  return Eigen::Quaterniond(std::cos(0.5 * angle), scale * vector.x(), scale * vector.y(), scale * vector.z())
      .normalized();
}

/// The shorter of the two ways round.
inline Eigen::Vector3d rotation_vector_of(const Eigen::Quaterniond& rotation) noexcept {
  const double sine = rotation.vec().norm();
  if (sine < 1e-12) return 2.0 * (rotation.w() < 0.0 ? -1.0 : 1.0) * rotation.vec();
  const double angle = 2.0 * std::atan2(rotation.w() < 0.0 ? -sine : sine, std::abs(rotation.w()));
  return angle / sine * rotation.vec();
}

/// What a small change of a rotation vector turns by: rotation_of(v + d) is about rotation_of(J d) *
/// rotation_of(v) (Sola, Deray, Atchuthan, A micro Lie theory, 2018, equation 145).
inline Eigen::Matrix3d left_jacobian(const Eigen::Vector3d& vector) noexcept {
  const double angle2 = vector.squaredNorm(), angle = std::sqrt(angle2);
  const Eigen::Matrix3d k = cross_matrix(vector);
  const double a = angle < 1e-4 ? 0.5 : (1.0 - std::cos(angle)) / angle2;
  const double b = angle < 1e-4 ? 1.0 / 6.0 : (angle - std::sin(angle)) / (angle2 * angle);
  return Eigen::Matrix3d::Identity() + a * k + b * k * k;
}

}  // namespace glint
