// SPDX-License-Identifier: MIT
// Where the markers of rigid bodies sit, and how such bodies turn.
#pragma once

#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "host/sim/options.hpp"

namespace glint::sim {

inline constexpr double kLeastMarkerGap_m = 0.03;  ///< between centres of markers of one body

/// One list per body: places within a ball of bodies.size_m around the body's origin, the first of them on
/// its surface. Of many draws the one is taken whose triangles of markers differ most, from each other, from
/// their own mirror orders and from those of the bodies before, so that any three markers tell which they
/// are; identical bodies share one draw. Throws Error if the markers do not fit into the ball.
std::vector<std::vector<Eigen::Vector3d>> body_shapes(const SimOptions& options);

/// How well three markers tell which they are: the least difference between the sides of a triangle, and
/// between the sorted sides of two triangles (of the longest of the three differences), in m.
double distinctness_m(const std::vector<std::vector<Eigen::Vector3d>>& bodies);

/// Attitude that turns about an axis which turns itself: about the body's y axis and, as a whole, about the
/// world's z axis, both evenly. The rate of turn is hypot(about_z, about_y).
struct Spin {
  double about_z_rad_s = 0.0, about_y_rad_s = 0.0;
  double z_phase_rad = 0.0, y_phase_rad = 0.0;
  Eigen::Quaterniond start = Eigen::Quaterniond::Identity();

  Eigen::Quaterniond at(double time_s) const noexcept;
};

class Random;
/// Evenly distributed attitude.
Eigen::Quaterniond any_attitude(Random& random);

}  // namespace glint::sim
