// SPDX-License-Identifier: MIT
// Random but sensible cameras that look at the origin, for property tests.
#pragma once

#include <cmath>
#include <random>
#include <vector>

#include "host/geometry/camera.hpp"

namespace glint::testing {

inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// A camera at `position` whose axis goes through `target`; x is horizontal, y points down.
inline Pose looking_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - position).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation.col(0) = x;
  rotation.col(1) = z.cross(x);
  rotation.col(2) = z;
  return {Eigen::Quaterniond(rotation), position};
}

inline CameraCalibration random_camera(std::mt19937_64& random) {
  CameraCalibration c;
  c.name = "random";
  c.width_px = 1280;
  c.height_px = 800;
  c.fx_px = uniform(random, 700, 1500);
  c.fy_px = c.fx_px * uniform(random, 0.98, 1.02);
  if (uniform(random, 0, 1) < 0.2) c.fy_px = -c.fy_px;
  c.cx_px = 639.5 + uniform(random, -20, 20);
  c.cy_px = 399.5 + uniform(random, -20, 20);
  c.k1_k2_p1_p2_k3 = {uniform(random, -0.25, 0.1), uniform(random, 0.0, 0.1), uniform(random, -2e-3, 2e-3),
                      uniform(random, -2e-3, 2e-3), uniform(random, 0.0, 0.02)};
  const double angle = uniform(random, 0, 2 * M_PI);
  c.world_from_camera = looking_at({4 * std::cos(angle), 4 * std::sin(angle), uniform(random, 0.5, 3.0)},
                                   Eigen::Vector3d::Zero());
  return c;
}

/// Within half a metre of the origin, so that every random camera sees it.
inline Eigen::Vector3d random_point(std::mt19937_64& random) {
  return {uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5)};
}

}  // namespace glint::testing
