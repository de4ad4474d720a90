// SPDX-License-Identifier: MIT
// Projection and its inverse belong together, and follow the conventions.
#include "host/geometry/camera.hpp"

#include <gtest/gtest.h>

#include "tests/unit/geometry/random_cameras.hpp"

namespace glint {
namespace {

using testing::random_camera;
using testing::random_point;

TEST(Camera, RayThroughThePixelOfAPointHitsThePoint) {
  std::mt19937_64 random(1);
  for (int k = 0; k < 500; ++k) {
    const Camera camera(random_camera(random));
    const Eigen::Vector3d point = random_point(random);
    const auto pixel = camera.project(point);
    ASSERT_TRUE(pixel);
    const auto normalized = camera.undistort(*pixel);
    ASSERT_TRUE(normalized);
    const Eigen::Vector3d direction = camera.direction_in_world(*normalized);
    EXPECT_LT((point - camera.position_in_world()).cross(direction).norm(), 1e-9);
    EXPECT_GT((point - camera.position_in_world()).dot(direction), 0.0);
  }
}

TEST(Camera, PinholePixelIsTheUndistortedOne) {
  std::mt19937_64 random(2);
  for (int k = 0; k < 200; ++k) {
    const CameraCalibration c = random_camera(random);
    const Camera camera(c);
    const Eigen::Vector3d point = random_point(random);
    const Eigen::Vector2d normalized = *camera.undistort(*camera.project(point));
    const Eigen::Vector2d pinhole = *camera.project_pinhole(point);
    EXPECT_NEAR(pinhole.x(), c.fx_px * normalized.x() + c.cx_px, 1e-6);
    EXPECT_NEAR(pinhole.y(), c.fy_px * normalized.y() + c.cy_px, 1e-6);
  }
}

TEST(Camera, AxesAreRightDownForward) {
  CameraCalibration c;
  c.width_px = c.height_px = 101;
  c.fx_px = c.fy_px = 100;
  c.cx_px = c.cy_px = 50;
  const Camera camera(c);  // at the origin, looking along z
  EXPECT_EQ(*camera.project({0, 0, 2}), Eigen::Vector2d(50, 50));
  EXPECT_EQ(*camera.project({1, 0, 2}), Eigen::Vector2d(100, 50));
  EXPECT_EQ(*camera.project({0, 1, 2}), Eigen::Vector2d(50, 100));
  EXPECT_FALSE(camera.project({0, 0, -2}));
  EXPECT_FALSE(camera.project_pinhole({1, 1, 0}));
}

TEST(Camera, ImageReachesHalfAPixelBeyondTheOuterCentres) {
  CameraCalibration c;
  c.width_px = 4;
  c.height_px = 3;
  const Camera camera(c);
  EXPECT_TRUE(camera.inside({-0.5, -0.5}));
  EXPECT_TRUE(camera.inside({3.5, 2.5}));
  EXPECT_FALSE(camera.inside({3.51, 1}));
  EXPECT_FALSE(camera.inside({1, -0.51}));
  EXPECT_FALSE(camera.inside({0.4, 1}, 1.0));
}

}  // namespace
}  // namespace glint
