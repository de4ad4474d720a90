// SPDX-License-Identifier: MIT
// Segments against cylinders and capsules.
#include "host/sim/obstacle.hpp"

#include <algorithm>
#include <cmath>

namespace glint::sim {

bool blocks(const Pole& pole, const Eigen::Vector3d& from, const Eigen::Vector3d& to) noexcept {
  const double dx = to.x() - from.x(), dy = to.y() - from.y();
  const double fx = from.x() - pole.x_m, fy = from.y() - pole.y_m;
  const double a = dx * dx + dy * dy, b = fx * dx + fy * dy,
               c = fx * fx + fy * fy - pole.radius_m * pole.radius_m;
  const double discriminant = b * b - a * c;
  if (discriminant <= 0.0 || a <= 0.0) return false;
  const double root = std::sqrt(discriminant);
  const double enter = std::max(0.0, (-b - root) / a), leave = std::min(1.0, (-b + root) / a);
  if (enter >= leave) return false;
  const double dz = to.z() - from.z();
  return std::min(from.z() + enter * dz, from.z() + leave * dz) < pole.height_m;
}

bool blocks(const Capsule& capsule, const Eigen::Vector3d& from, const Eigen::Vector3d& to) noexcept {
  // Nearest points of two segments, from + s * along and axis_start + t * axis: the unconstrained minimum in
  // s, then t for that s, then s again for the clamped t, is exact because the distance is convex.
  const Eigen::Vector3d along = to - from, axis = capsule.to_in_world - capsule.from_in_world,
                        between = from - capsule.from_in_world;
  const double aa = along.squaredNorm(), ab = along.dot(axis), bb = axis.squaredNorm();
  const double a_between = along.dot(between), b_between = axis.dot(between);
  if (aa <= 0.0) return false;
  const double determinant = aa * bb - ab * ab;
  double s = determinant > 0.0 ? std::clamp((ab * b_between - bb * a_between) / determinant, 0.0, 1.0) : 0.0;
  const double t = bb > 0.0 ? std::clamp((ab * s + b_between) / bb, 0.0, 1.0) : 0.0;
  s = std::clamp((ab * t - a_between) / aa, 0.0, 1.0);
  return (between + s * along - t * axis).squaredNorm() < capsule.radius_m * capsule.radius_m;
}

}  // namespace glint::sim
