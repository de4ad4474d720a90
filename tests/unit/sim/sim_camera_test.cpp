// SPDX-License-Identifier: MIT
// Projection agrees with the geometry module; a ball's outline is the exact one.
#include "host/sim/sim_camera.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "host/sim/random.hpp"
#include "host/sim/rig.hpp"

namespace glint::sim {
namespace {

TEST(SimCamera, ProjectsAsTheGeometryModuleDoes) {
  Random random(7);
  for (const CameraCalibration& calibration : sim_calibration({}).cameras) {
    const SimCamera camera(calibration);
    const Camera other(calibration);
    for (int i = 0; i < 200; ++i) {
      const Eigen::Vector3d point(random.uniform(-1.5, 1.5), random.uniform(-1.5, 1.5), random.uniform(0, 2));
      const Eigen::Vector3d point_in_camera = camera.in_camera(point);
      if (!camera.images(point_in_camera, 0.0063)) continue;
      EXPECT_LT((camera.project(point_in_camera) - other.project(point).value()).norm(), 1e-8);
    }
  }
}

TEST(SimCamera, DerivativeIsTheDerivative) {
  const SimCamera camera(sim_calibration({}).cameras[1]);
  const Eigen::Vector3d point(0.9, -0.5, 2.2);
  Eigen::Matrix<double, 2, 3> derivative;
  camera.project(point, &derivative);
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector3d step = 1e-6 * Eigen::Vector3d::Unit(axis);
    const Eigen::Vector2d slope = (camera.project(point + step) - camera.project(point - step)) / 2e-6;
    EXPECT_LT((slope - derivative.col(axis)).norm(), 1e-5);
  }
}

TEST(SimCamera, RaysThroughTheOutlineTouchTheBall) {
  const CameraCalibration calibration = sim_calibration({}).cameras[2];
  const SimCamera camera(calibration);
  const Camera geometry(calibration);
  const Eigen::Vector3d centre(0.7, 0.4, 1.5);
  constexpr double kRadius_m = 0.02;
  std::array<OutlinePoint, 40> outline;
  camera.outline(centre, kRadius_m, outline);
  for (const OutlinePoint& p : outline) {
    const Eigen::Vector2d plane = geometry.undistort({p.x_px, p.y_px}).value();
    const Eigen::Vector3d ray = Eigen::Vector3d(plane.x(), plane.y(), 1.0).normalized();
    EXPECT_NEAR(centre.cross(ray).norm(), kRadius_m, 1e-8);
  }
}

TEST(SimCamera, OutlineTangentsCloseAndMatchDifferences) {
  const SimCamera camera(sim_calibration({}).cameras[0]);
  std::array<OutlinePoint, 360> outline;
  camera.outline({-0.8, 0.3, 1.4}, 0.0063, outline);
  double sum_x = 0.0, sum_y = 0.0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const OutlinePoint &before = outline[(i + 359) % 360], &after = outline[(i + 1) % 360];
    EXPECT_NEAR(outline[i].dx_px, 0.5 * (after.x_px - before.x_px), 1e-5);
    EXPECT_NEAR(outline[i].dy_px, 0.5 * (after.y_px - before.y_px), 1e-5);
    sum_x += outline[i].dx_px;
    sum_y += outline[i].dy_px;
  }
  EXPECT_NEAR(sum_x, 0.0, 1e-9);
  EXPECT_NEAR(sum_y, 0.0, 1e-9);
}

TEST(SimCamera, MeanOfABallIsBiasedOutwardsByTheKnownAmount) {
  // Without distortion the image is an ellipse whose middle lies off the projected centre by
  // f tan(t) sec^2(t) alpha^2, alpha being the ball's angular radius (leading term).
  CameraCalibration calibration = sim_calibration({}).cameras[0];
  calibration.k1_k2_p1_p2_k3 = {};
  calibration.fx_px = calibration.fy_px = 914.0;
  const SimCamera camera(calibration);
  for (const double degrees : {0.0, 20.0, 35.0}) {
    const double theta = degrees * std::numbers::pi / 180.0, distance = 1.0, radius = 0.0095;
    const Eigen::Vector3d centre(distance * std::sin(theta), 0.0, distance * std::cos(theta));
    std::array<OutlinePoint, 64> outline;
    camera.outline(centre, radius, outline);
    const OutlineMoments shape = moments(outline);
    const double expected = 914.0 * std::tan(theta) / (std::cos(theta) * std::cos(theta)) * radius * radius;
    EXPECT_NEAR(shape.mean_px.x() - camera.project(centre).x(), expected, 0.01 * expected + 1e-9);
    const double semi = 914.0 * radius / (std::cos(theta) * distance);  // across; along it is longer by 1/cos
    EXPECT_NEAR(shape.area_px2, std::numbers::pi * semi * semi / std::cos(theta), 0.002 * shape.area_px2);
  }
}

TEST(SimCamera, BehindOrBeyondTheFoldIsNotImaged) {
  const SimCamera camera(sim_calibration({}).cameras[0]);
  EXPECT_TRUE(camera.images({0, 0, 2}, 0.01));
  EXPECT_FALSE(camera.images({0, 0, -2}, 0.01));
  EXPECT_FALSE(camera.images({0, 0, 0.01}, 0.01));
  EXPECT_FALSE(camera.images({6, 0, 2}, 0.01));  // the polynomial would fold this back into the image
}

TEST(SimCamera, TurnedCameraMovesTheImage) {
  const SimCamera camera(sim_calibration({}).cameras[0]);
  const Eigen::Vector3d point(0, 0, 1);
  const SimCamera turned = camera.turned(0.01);
  const Eigen::Vector2d moved =
      turned.project(turned.in_camera(point)) - camera.project(camera.in_camera(point));
  EXPECT_NEAR(moved.x(), -0.01 * camera.calibration().fx_px, 0.2);
  EXPECT_NEAR(moved.y(), 0.0, 0.2);
}

}  // namespace
}  // namespace glint::sim
