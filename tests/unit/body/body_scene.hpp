// SPDX-License-Identifier: MIT
// Made-up bodies and what cameras see of them, for the tests of host/body.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "host/body/body_finder.hpp"
#include "host/body/body_model.hpp"
#include "host/geometry/rotation.hpp"
#include "host/geometry/triangulate.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint::testing {

inline Eigen::Vector3d normal3(std::mt19937_64& random, double sd) {
  std::normal_distribution<double> normal;
  return sd * Eigen::Vector3d(normal(random), normal(random), normal(random));
}

/// Markers at least 3 cm apart within a ball of 0.2 m, the nth name.
inline BodyModel random_body(std::mt19937_64& random, std::size_t markers, const std::string& name) {
  BodyModel model;
  model.name = name;
  while (model.markers_in_body.size() < markers) {
    const Eigen::Vector3d p(uniform(random, -0.1, 0.1), uniform(random, -0.1, 0.1),
                            uniform(random, -0.1, 0.1));
    bool fits = p.norm() < 0.1;
    for (const Eigen::Vector3d& other : model.markers_in_body) fits = fits && (p - other).norm() > 0.03;
    if (fits) model.markers_in_body.push_back(p);
  }
  return model;
}

inline Pose random_pose(std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Pose pose;
  pose.rotation =
      Eigen::Quaterniond(normal(random), normal(random), normal(random), normal(random)).normalized();
  pose.translation = {uniform(random, -1.0, 1.0), uniform(random, -1.0, 1.0), uniform(random, 0.3, 1.4)};
  return pose;
}

inline std::vector<Camera> cameras_of(const Calibration& calibration) {
  return {calibration.cameras.begin(), calibration.cameras.end()};
}

/// What each camera that has the point in its image measures of it.
inline std::vector<Observation> observe(const std::vector<Camera>& cameras, const Eigen::Vector3d& point,
                                        double sd_px, double missing, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  std::vector<Observation> views;
  for (const Camera& camera : cameras) {
    const auto pixel = camera.project_pinhole(point);
    if (!pixel || !camera.inside(*pixel) || uniform(random, 0, 1) < missing) continue;
    const CameraCalibration& c = camera.calibration();
    const Eigen::Vector2d seen = *pixel + sd_px * Eigen::Vector2d(normal(random), normal(random));
    views.push_back({&camera,
                     {(seen.x() - c.cx_px) / c.fx_px, (seen.y() - c.cy_px) / c.fy_px},
                     sd_px * sd_px * Eigen::Matrix2d::Identity()});
  }
  return views;
}

}  // namespace glint::testing
