// SPDX-License-Identifier: MIT
// Rays of one camera on a plane of known height.
#include "host/geometry/floor_point.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

#include "host/geometry/sphere_bias.hpp"

namespace glint {
namespace {

/// At 3 m, turned by that much from looking straight down towards +y.
CameraCalibration ceiling_camera(double off_vertical_rad) {
  CameraCalibration c;
  c.name = "ceiling";
  c.width_px = 1280;
  c.height_px = 800;
  c.fx_px = 914.0;
  c.fy_px = 916.0;
  c.cx_px = 637.0;
  c.cy_px = 402.0;
  c.k1_k2_p1_p2_k3 = {-0.32, 0.12, 2e-4, -3e-4, -0.02};
  const Eigen::AngleAxisd down(std::numbers::pi, Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd tilt(off_vertical_rad, Eigen::Vector3d::UnitX());
  c.world_from_camera.rotation = Eigen::Quaterniond(tilt * down);
  c.world_from_camera.translation = {0.2, -0.1, 3.0};
  return c;
}

Eigen::Vector2d normalized(const Camera& camera, const Eigen::Vector3d& point) {
  return camera.in_camera(point).hnormalized();
}

TEST(FloorPoint, GivesBackThePoint) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> across(-1.5, 1.5), up(-0.2, 1.5);
  for (const double tilt : {0.0, 0.3, 0.8}) {
    const Camera camera(ceiling_camera(tilt));
    for (int n = 0; n < 100; ++n) {
      const Eigen::Vector3d point(across(random), across(random) + 3.0 * std::tan(tilt), up(random));
      const auto found = floor_point({&camera, normalized(camera, point)}, point.z(), 0.0);
      ASSERT_TRUE(found);
      EXPECT_LT((found->position_in_world - point).norm(), 1e-9);
    }
  }
}

TEST(FloorPoint, RemovesTheSpheresBias) {
  const Camera camera(ceiling_camera(0.5));
  const Eigen::Vector3d ball(0.9, 2.2, 0.3);
  constexpr double kRadius = 0.04;
  const Eigen::Vector3d in_camera = camera.in_camera(ball);
  const Eigen::Vector2d outline = in_camera.hnormalized() * sphere_bias_factor(kRadius, in_camera.z());
  const auto found = floor_point({&camera, outline}, ball.z(), kRadius);
  ASSERT_TRUE(found);
  EXPECT_LT((found->position_in_world - ball).norm(), 1e-6);
  const auto biased = floor_point({&camera, outline}, ball.z(), 0.0);
  EXPECT_GT((biased->position_in_world - ball).norm(), 1e-4);
}

TEST(FloorPoint, WithoutTheHeightItIsOffByHeightTimesTangent) {
  const Camera camera(ceiling_camera(0.0));
  const Eigen::Vector3d marker(0.2, -0.1 + 1.5, 0.3);  // 1.5 m beside the camera's foot
  const auto on_floor = floor_point({&camera, normalized(camera, marker)}, 0.0, 0.0);
  ASSERT_TRUE(on_floor);
  EXPECT_NEAR((on_floor->position_in_world - marker).head<2>().norm(), 0.3 * 1.5 / 2.7, 1e-9);
}

TEST(FloorPoint, ItsCovarianceIsThatOfTheScatter) {
  const Camera camera(ceiling_camera(0.6));
  const Eigen::Vector3d point(-0.8, 3.0, 0.3);
  Eigen::Matrix2d pixels;
  pixels << 0.04, 0.01, 0.01, 0.09;
  constexpr double kHeightSd = 0.002;
  const Eigen::Matrix2d root = pixels.llt().matrixL();
  std::mt19937_64 random(2);
  std::normal_distribution<double> normal;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  constexpr int kDraws = 20'000;
  const CameraCalibration& c = camera.calibration();
  for (int n = 0; n < kDraws; ++n) {
    const Eigen::Vector2d off = root * Eigen::Vector2d(normal(random), normal(random));
    const Eigen::Vector2d seen =
        normalized(camera, point) + Eigen::Vector2d(off.x() / c.fx_px, off.y() / c.fy_px);
    const auto found = floor_point({&camera, seen}, point.z() + kHeightSd * normal(random), 0.0);
    const Eigen::Vector3d error = found->position_in_world - point;
    scatter += error * error.transpose() / kDraws;
  }
  const auto told = floor_point({&camera, normalized(camera, point), pixels}, point.z(), 0.0, kHeightSd);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      EXPECT_NEAR(told->covariance_m2(row, column), scatter(row, column), 0.05 * scatter.trace());
}

TEST(FloorPoint, NothingWhereTheRayMissesThePlaneOrRunsAlongIt) {
  const Camera down(ceiling_camera(0.0));
  const Eigen::Vector2d middle = Eigen::Vector2d::Zero();
  EXPECT_TRUE(floor_point({&down, middle}, 0.0, 0.0));
  EXPECT_FALSE(floor_point({&down, middle}, 3.5, 0.0)) << "above the camera";
  EXPECT_FALSE(floor_point({&down, middle}, 3.0, 0.0)) << "through the camera";
  const Camera level(ceiling_camera(std::numbers::pi / 2.0));
  const double degree = std::numbers::pi / 180.0;
  EXPECT_FALSE(floor_point({&level, {0.0, std::tan(4.0 * degree)}}, 0.0, 0.0));
  EXPECT_TRUE(floor_point({&level, {0.0, std::tan(6.0 * degree)}}, 0.0, 0.0));
  EXPECT_FALSE(floor_point({&level, {0.0, -std::tan(6.0 * degree)}}, 0.0, 0.0)) << "the sky";
  EXPECT_TRUE(floor_point({&level, {0.0, -std::tan(6.0 * degree)}}, 5.0, 0.0)) << "a plane above is one, too";
}

TEST(FloorPoint, TheImageAsAWhole) {
  EXPECT_EQ(sight_of_plane(Camera(ceiling_camera(0.0)), 0.0), PlaneSight::Seen);
  EXPECT_EQ(sight_of_plane(Camera(ceiling_camera(0.0)), 4.0), PlaneSight::Behind);
  EXPECT_EQ(sight_of_plane(Camera(ceiling_camera(std::numbers::pi / 2.0)), 0.0), PlaneSight::Seen);
  CameraCalibration narrow = ceiling_camera(std::numbers::pi / 2.0);
  narrow.fx_px = narrow.fy_px = 20'000.0;
  EXPECT_EQ(sight_of_plane(Camera(narrow), 0.0), PlaneSight::EdgeOn);
}

}  // namespace
}  // namespace glint
