// SPDX-License-Identifier: MIT
// Poses of targets from one image: exact, with noise, with the depth ambiguity, and where there is none.
#include "host/calibrate/pnp.hpp"

#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

namespace glint {
namespace {

CameraCalibration wide_camera() {
  CameraCalibration c;
  c.width_px = 1280;
  c.height_px = 800;
  c.fx_px = 920.0;
  c.fy_px = 921.0;
  c.cx_px = 645.0;
  c.cy_px = 392.0;
  c.k1_k2_p1_p2_k3 = {-0.32, 0.12, 3e-4, -4e-4, -0.02};
  return c;
}

std::vector<Eigen::Vector3d> grid(int columns, int rows, double step_m) {
  std::vector<Eigen::Vector3d> points;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) points.emplace_back(x * step_m, y * step_m, 0.0);
  return points;
}

double draw(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

/// Looks roughly along the target's z axis at its middle, tilted by up to `tilt_rad`.
Pose random_pose(std::mt19937_64& random, const std::vector<Eigen::Vector3d>& points, double distance_m,
                 double tilt_rad) {
  const double direction = draw(random, 0.0, 2.0 * std::numbers::pi);
  const Eigen::Vector3d axis(std::cos(direction), std::sin(direction), 0.0);
  const Eigen::Quaterniond rotation(
      Eigen::AngleAxisd(draw(random, 0.0, tilt_rad), axis) *
      Eigen::AngleAxisd(draw(random, -std::numbers::pi, std::numbers::pi), Eigen::Vector3d::UnitZ()));
  Eigen::Vector3d middle = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) middle += p / static_cast<double>(points.size());
  const Eigen::Vector3d at(draw(random, -0.4, 0.4) * distance_m, draw(random, -0.25, 0.25) * distance_m,
                           distance_m);
  return {rotation, at - rotation * middle};
}

std::vector<Eigen::Vector2d> seen(const CameraCalibration& camera, const Pose& camera_from_target,
                                  const std::vector<Eigen::Vector3d>& points, double sigma_px,
                                  std::mt19937_64& random) {
  CameraCalibration at_origin = camera;
  at_origin.world_from_camera = Pose{};
  const Camera model(at_origin);
  std::normal_distribution<double> noise(0.0, 1.0);
  std::vector<Eigen::Vector2d> pixels;
  for (const Eigen::Vector3d& p : points) {
    pixels.push_back(model.project(camera_from_target * p).value() +
                     sigma_px * Eigen::Vector2d(noise(random), noise(random)));
  }
  return pixels;
}

TEST(Pnp, FindsTheExactPoseOfAPlaneFromFourPointsOn) {
  std::mt19937_64 random(1);
  const CameraCalibration camera = wide_camera();
  for (const auto& points : {grid(2, 2, 0.3), grid(3, 2, 0.1), grid(9, 6, 0.025)}) {
    for (int i = 0; i < 100; ++i) {
      const Pose truth = random_pose(random, points, draw(random, 0.5, 3.0), 1.0);
      const auto found = camera_from_target(camera, points, seen(camera, truth, points, 0.0, random));
      ASSERT_TRUE(found);
      EXPECT_LT(found->rotation.angularDistance(truth.rotation), 1e-6)
          << points.size() << " points, case " << i;
      EXPECT_LT((found->translation - truth.translation).norm(), 1e-6);
    }
  }
}

TEST(Pnp, AnyPlaneWillDoNotOnlyThatOfZ0) {
  std::mt19937_64 random(2);
  const Pose shifted{Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized(), {0.4, -1.0, 0.2}};
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3d& p : grid(5, 4, 0.05)) points.push_back(shifted * p);
  const Pose truth = random_pose(random, grid(5, 4, 0.05), 1.0, 0.8) * shifted.inverse();
  const auto found =
      camera_from_target(wide_camera(), points, seen(wide_camera(), truth, points, 0.0, random));
  ASSERT_TRUE(found);
  EXPECT_LT(found->rotation.angularDistance(truth.rotation), 1e-6);
  EXPECT_LT((found->translation - truth.translation).norm(), 1e-6);
}

TEST(Pnp, PointsInSpace) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 100; ++i) {
    std::vector<Eigen::Vector3d> points;
    for (int n = 0; n < 8; ++n)
      points.emplace_back(draw(random, -0.3, 0.3), draw(random, -0.3, 0.3), draw(random, -0.3, 0.3));
    const Pose truth = random_pose(random, points, 2.0, 1.0);
    const auto found =
        camera_from_target(wide_camera(), points, seen(wide_camera(), truth, points, 0.0, random));
    ASSERT_TRUE(found) << "case " << i;
    EXPECT_LT(found->rotation.angularDistance(truth.rotation), 1e-6) << "case " << i;
  }
}

TEST(Pnp, NoiseMakesTheErrorsThatItMust) {
  std::mt19937_64 random(4);
  const auto points = grid(9, 6, 0.025);
  double squares = 0.0;
  int wrong = 0;
  constexpr int kCases = 300;
  for (int i = 0; i < kCases; ++i) {
    const Pose truth = random_pose(random, points, 0.8, 0.8);
    const auto poses = target_poses(wide_camera(), points, seen(wide_camera(), truth, points, 0.2, random));
    ASSERT_FALSE(poses.empty());
    squares += poses.front().rms_px * poses.front().rms_px;
    if (poses.front().camera_from_target.rotation.angularDistance(truth.rotation) > 0.02) ++wrong;
  }
  EXPECT_EQ(wrong, 0);
  // 108 numbers with 6 unknowns: 0.2 * sqrt(2) px a point, less what the fit takes.
  EXPECT_NEAR(std::sqrt(squares / kCases), 0.2 * std::sqrt(2.0 * 102.0 / 108.0), 0.006);
}

TEST(Pnp, BothPosesOfAFarBoardAreFoundAndTheTrueOneIsAmongThem) {
  std::mt19937_64 random(5);
  const auto points = grid(4, 3, 0.02);  // a small board far away: nearly no perspective
  int two = 0;
  for (int i = 0; i < 200; ++i) {
    const Pose truth = random_pose(random, points, 3.0, 0.7);
    const auto poses = target_poses(wide_camera(), points, seen(wide_camera(), truth, points, 0.05, random));
    ASSERT_FALSE(poses.empty());
    two += poses.size() == 2;
    double nearest = 10.0;
    for (const TargetPose& pose : poses)
      nearest = std::min(nearest, pose.camera_from_target.rotation.angularDistance(truth.rotation));
    EXPECT_LT(nearest, 0.35) << "case " << i;
  }
  EXPECT_GT(two, 100);
}

TEST(Pnp, NothingWhereThereIsNothing) {
  std::mt19937_64 random(6);
  const auto line = grid(6, 1, 0.1);
  const Pose truth = random_pose(random, line, 2.0, 0.5);
  EXPECT_FALSE(camera_from_target(wide_camera(), line, seen(wide_camera(), truth, line, 0.0, random)));
  const auto three = grid(3, 1, 0.1);
  EXPECT_FALSE(camera_from_target(wide_camera(), three, seen(wide_camera(), truth, three, 0.0, random)));
  const auto board = grid(5, 4, 0.05);
  const std::vector<Eigen::Vector2d> same(board.size(), Eigen::Vector2d(600.0, 400.0));
  EXPECT_FALSE(camera_from_target(wide_camera(), board, same));
}

}  // namespace
}  // namespace glint
