// SPDX-License-Identifier: MIT
// What a marker should look like, beside the exact outline of the simulator.
#include "host/resolve/expected_disc.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include <Eigen/LU>

#include "host/geometry/sphere_bias.hpp"
#include "host/sim/random.hpp"
#include "host/sim/sim_camera.hpp"

namespace glint {
namespace {

CameraCalibration wide_camera(sim::Random& random) {
  CameraCalibration c;
  c.width_px = 1280, c.height_px = 800;
  c.fx_px = 914.0, c.fy_px = 917.0, c.cx_px = 642.0, c.cy_px = 396.0;
  c.k1_k2_p1_p2_k3 = {-0.32, 0.12, 4e-4, -3e-4, -0.02};
  c.world_from_camera.rotation =
      Eigen::Quaterniond(Eigen::Vector4d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1),
                                         random.uniform(-1, 1))
                             .normalized());
  c.world_from_camera.translation = {random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(0, 3)};
  return c;
}

struct Ball {
  CameraCalibration calibration;
  Eigen::Vector3d in_camera, in_world;
  double radius_px;
};

/// Balls of 1 to 12 px in radius all over the image.
Ball any_ball(sim::Random& random, double radius_m) {
  Ball ball;
  ball.calibration = wide_camera(random);
  ball.radius_px = random.uniform(1.0, 12.0);
  const double z = 914.0 * radius_m / ball.radius_px;
  ball.in_camera = {random.uniform(-0.7, 0.7) * z, random.uniform(-0.43, 0.43) * z, z};
  ball.in_world = ball.calibration.world_from_camera.rotation * ball.in_camera +
                  ball.calibration.world_from_camera.translation;
  return ball;
}

constexpr double kRadius_m = 0.0063;

TEST(ExpectedDisc, CentroidAndShapeAreThoseOfTheExactOutline) {
  sim::Random random(4);
  double worst_px = 0.0, worst_shape = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Ball ball = any_ball(random, kRadius_m);
    const auto disc =
        expected_disc(Camera(ball.calibration), ball.in_world, Eigen::Vector3d::Zero(), kRadius_m, 0.0);
    ASSERT_TRUE(disc);
    std::array<sim::OutlinePoint, 256> outline;
    sim::SimCamera(ball.calibration).outline(ball.in_camera, kRadius_m, outline);
    const sim::OutlineMoments exact = sim::moments(outline);
    worst_px = std::max(worst_px, (disc->centre_px - exact.mean_px).norm());
    EXPECT_NEAR(disc->distance_m, ball.in_camera.norm(), 1e-9);
    const Eigen::Matrix2d inverse = disc->shape_px2.inverse();
    for (const sim::OutlinePoint& p : outline) {
      const Eigen::Vector2d v = Eigen::Vector2d(p.x_px, p.y_px) - disc->centre_px;
      worst_shape = std::max(worst_shape, std::abs(std::sqrt(v.dot(inverse * v)) - 1.0) * ball.radius_px);
    }
  }
  std::printf("worst centroid %.5f px, worst outline %.4f px\n", worst_px, worst_shape);
  EXPECT_LT(worst_px, 0.002);
  EXPECT_LT(worst_shape, 0.1);
}

TEST(ExpectedDisc, BackToTheRayOfTheSphere) {
  sim::Random random(5);
  double worst_px = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Ball ball = any_ball(random, kRadius_m);
    const Camera camera(ball.calibration);
    const auto disc = expected_disc(camera, ball.in_world, Eigen::Vector3d::Zero(), kRadius_m, 0.0);
    ASSERT_TRUE(disc);
    std::array<sim::OutlinePoint, 256> outline;
    sim::SimCamera(ball.calibration).outline(ball.in_camera, kRadius_m, outline);
    const auto centre =
        outline_centre(camera, sim::moments(outline).mean_px, disc->shape_px2, Eigen::Matrix2d::Identity());
    ASSERT_TRUE(centre);
    const Eigen::Vector2d found = remove_sphere_bias(centre->normalized, kRadius_m, ball.in_camera.z());
    worst_px = std::max(worst_px, 914.0 * (found - ball.in_camera.hnormalized()).norm());
  }
  std::printf("worst ray %.5f px\n", worst_px);
  EXPECT_LT(worst_px, 0.005);
}

TEST(ExpectedDisc, CovarianceGoesThroughTheLens) {
  sim::Random random(6);
  for (int i = 0; i < 200; ++i) {
    const Ball ball = any_ball(random, kRadius_m);
    const Camera camera(ball.calibration);
    const auto disc = expected_disc(camera, ball.in_world, Eigen::Vector3d::Zero(), kRadius_m, 0.0);
    ASSERT_TRUE(disc);
    Eigen::Matrix2d covariance;
    covariance << 4e-4, 1e-4, 1e-4, 2e-4;
    const auto at = [&](double dx, double dy) {
      const auto c =
          outline_centre(camera, disc->centre_px + Eigen::Vector2d(dx, dy), disc->shape_px2, covariance);
      return Eigen::Vector2d(914.0 * c->normalized.x(), 917.0 * c->normalized.y());
    };
    Eigen::Matrix2d by;
    by << (at(0.01, 0) - at(-0.01, 0)) / 0.02, (at(0, 0.01) - at(0, -0.01)) / 0.02;
    const Eigen::Matrix2d expected = by * covariance * by.transpose();
    const Eigen::Matrix2d found =
        outline_centre(camera, disc->centre_px, disc->shape_px2, covariance)->covariance_px2;
    EXPECT_LT((found - expected).norm(), 2e-3 * expected.norm());
  }
}

TEST(ExpectedDisc, MotionIsThePathOverTheExposure) {
  sim::Random random(7);
  for (int i = 0; i < 200; ++i) {
    const Ball ball = any_ball(random, kRadius_m);
    const Camera camera(ball.calibration);
    const Eigen::Vector3d velocity(random.uniform(-7, 7), random.uniform(-7, 7), random.uniform(-7, 7));
    constexpr double kExposure_s = 137e-6;
    const auto disc = expected_disc(camera, ball.in_world, velocity, kRadius_m, kExposure_s);
    ASSERT_TRUE(disc);
    const auto end = camera.project(ball.in_world + 0.5 * kExposure_s * velocity);
    const auto start = camera.project(ball.in_world - 0.5 * kExposure_s * velocity);
    EXPECT_LT((disc->motion_px - (*end - *start)).norm(), 1e-3 * (1.0 + disc->motion_px.norm()));
  }
}

TEST(ExpectedDisc, NothingBehindTheCameraOrBeyondTheFold) {
  sim::Random random(8);
  Ball ball = any_ball(random, kRadius_m);
  const auto see = [&](const Eigen::Vector3d& in_camera, double radius_m) {
    return expected_disc(Camera(ball.calibration),
                         ball.calibration.world_from_camera.rotation * in_camera +
                             ball.calibration.world_from_camera.translation,
                         Eigen::Vector3d::Zero(), radius_m, 0.0)
        .has_value();
  };
  EXPECT_TRUE(see({0.1, 0.0, 1.0}, kRadius_m));
  EXPECT_FALSE(see({0.1, 0.0, -1.0}, kRadius_m));
  EXPECT_FALSE(see({0.0, 0.0, 0.005}, kRadius_m));
  EXPECT_FALSE(see({0.1, 0.0, 1.0}, 0.0));
  ball.calibration.k1_k2_p1_p2_k3 = {-0.4, 0, 0, 0, 0};  // folds at 42 degrees
  EXPECT_FALSE(see({1.2, 0.0, 1.0}, kRadius_m));
}

}  // namespace
}  // namespace glint
