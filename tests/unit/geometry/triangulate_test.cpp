// SPDX-License-Identifier: MIT
// Triangulation gives back what was projected, knows its own error, and refuses what it cannot do.
#include "host/geometry/triangulate.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "host/geometry/sphere_bias.hpp"
#include "tests/unit/geometry/random_cameras.hpp"

namespace glint {
namespace {

using testing::looking_at;
using testing::random_camera;
using testing::random_point;

std::vector<Observation> observe(const std::vector<Camera>& cameras, const Eigen::Vector3d& point,
                                 double sigma_px) {
  std::vector<Observation> views;
  for (const Camera& camera : cameras)
    views.push_back({&camera, *camera.undistort(*camera.project(point)),
                     sigma_px * sigma_px * Eigen::Matrix2d::Identity()});
  return views;
}

std::vector<Camera> ring_of_cameras(int count) {
  std::vector<Camera> cameras;
  for (int k = 0; k < count; ++k) {
    CameraCalibration c;
    c.width_px = 1280;
    c.height_px = 800;
    c.fx_px = c.fy_px = 914;
    c.cx_px = 639.5;
    c.cy_px = 399.5;
    const double angle = 0.3 + k * 2 * M_PI / count;
    c.world_from_camera = looking_at({3.5 * std::cos(angle), 3.5 * std::sin(angle), 2.0}, {0, 0, 0.8});
    cameras.emplace_back(c);
  }
  return cameras;
}

void shift(Observation& view, double dx_px, double dy_px) {
  const CameraCalibration& c = view.camera->calibration();
  view.normalized += Eigen::Vector2d(dx_px / c.fx_px, dy_px / c.fy_px);
}

TEST(Triangulate, ProjectUndistortTriangulateIsARoundTrip) {
  std::mt19937_64 random(3);
  int usable = 0;
  for (int k = 0; k < 500; ++k) {
    std::vector<Camera> cameras;
    const int count = 2 + k % 7;
    for (int c = 0; c < count; ++c) cameras.emplace_back(random_camera(random));
    const Eigen::Vector3d point = random_point(random);
    const auto found = triangulate(observe(cameras, point, 0.1), {});
    if (!found) continue;  // two random cameras may stand on one line with the point
    ++usable;
    EXPECT_EQ(found->views, static_cast<unsigned>(count));
    EXPECT_LT(found->rms_px, 1e-6);
    for (const Camera& camera : cameras)
      EXPECT_LT((*camera.project(found->position_in_world) - *camera.project(point)).norm(), 1e-6);
  }
  EXPECT_GT(usable, 480);
}

TEST(Triangulate, CovarianceIsWhatRepeatedMeasurementsScatter) {
  std::mt19937_64 random(4);
  std::normal_distribution<double> normal;
  const auto cameras = ring_of_cameras(3);
  const Eigen::Vector3d point(0.4, -0.3, 1.1);
  const auto exact = observe(cameras, point, 1.0);
  // Each camera with its own precision: the weights matter.
  const double sigma_px[] = {0.05, 0.3, 0.1};
  constexpr int kTrials = 20000;
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero(), claimed;
  double chi2 = 0.0;
  for (int trial = 0; trial < kTrials; ++trial) {
    auto views = exact;
    for (std::size_t k = 0; k < views.size(); ++k) {
      shift(views[k], sigma_px[k] * normal(random), sigma_px[k] * normal(random));
      views[k].covariance_px2 = sigma_px[k] * sigma_px[k] * Eigen::Matrix2d::Identity();
    }
    const auto found = triangulate(views, {});
    ASSERT_TRUE(found);
    const Eigen::Vector3d error = found->position_in_world - point;
    scatter += error * error.transpose() / kTrials;
    claimed = found->covariance_m2;
    chi2 += found->chi2 / kTrials;
  }
  const Eigen::Matrix3d ratio = claimed.inverse() * scatter;
  EXPECT_NEAR(ratio.trace() / 3.0, 1.0, 0.05);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(scatter(k, k) / claimed(k, k), 1.0, 0.1);
  EXPECT_NEAR(chi2, 3.0, 0.1);  // 2 * 3 - 3 degrees of freedom
}

TEST(Triangulate, AnisotropicCovarianceLetsTheBadDirectionGo) {
  const auto cameras = ring_of_cameras(4);
  const Eigen::Vector3d point(0.1, 0.2, 0.9);
  auto views = observe(cameras, point, 0.03);
  shift(views[1], 1.0, 0.0);
  const auto averaged = triangulate(views, {});
  views[1].covariance_px2(0, 0) = 1.0;
  const auto weighted = triangulate(views, {});
  ASSERT_TRUE(averaged && weighted);
  EXPECT_GT((averaged->position_in_world - point).norm(), 5e-4);
  EXPECT_LT((weighted->position_in_world - point).norm(), 1e-5);
}

TEST(Triangulate, PriorCountsAsAMeasurement) {
  const auto cameras = ring_of_cameras(2);
  const Eigen::Vector3d point(0, 0, 1);
  auto views = observe(cameras, point, 1.0);
  shift(views[0], 2.0, 0.0);
  const PositionPrior prior{point, 1e-8 * Eigen::Matrix3d::Identity()};
  const auto free = triangulate(views, {}), held = triangulate(views, {}, &prior);
  ASSERT_TRUE(free && held);
  EXPECT_GT((free->position_in_world - point).norm(), 1e-3);
  EXPECT_LT((held->position_in_world - point).norm(), 1e-4);
}

TEST(Triangulate, SphereBiasIsRemoved) {
  const auto cameras = ring_of_cameras(3);
  const double radius_m = 0.05;
  const Eigen::Vector3d point(0.9, -0.8, 1.6);
  auto views = observe(cameras, point, 0.05);
  for (Observation& view : views)
    view.normalized *= sphere_bias_factor(radius_m, view.camera->in_camera(point).z());
  TriangulateOptions options;
  const auto biased = triangulate(views, options);
  options.marker_radius_m = radius_m;
  const auto corrected = triangulate(views, options);
  ASSERT_TRUE(biased && corrected);
  EXPECT_GT((biased->position_in_world - point).norm(), 1e-4);
  EXPECT_LT((corrected->position_in_world - point).norm(), 1e-9);
}

TEST(Triangulate, RefusesWhatIsNotAPoint) {
  const auto cameras = ring_of_cameras(4);
  const Eigen::Vector3d point(0, 0, 0.8);
  const auto views = observe(cameras, point, 0.1);
  EXPECT_FALSE(triangulate(std::span(views).first(1), {})) << "one view";
  EXPECT_FALSE(triangulate({}, {})) << "no view";
  const std::vector<Observation> twice{views[0], views[0]};
  EXPECT_FALSE(triangulate(twice, {})) << "the same ray twice";

  // Cameras 0 and 2 stand opposite; on the line between them the rays are one line.
  const Eigen::Vector3d middle = 0.5 * (cameras[0].position_in_world() + cameras[2].position_in_world());
  std::vector<Camera> facing;
  for (int k : {0, 2}) {
    CameraCalibration c = cameras[static_cast<std::size_t>(k)].calibration();
    c.world_from_camera = looking_at(c.world_from_camera.translation, middle);
    facing.emplace_back(c);
  }
  EXPECT_FALSE(triangulate(observe(facing, middle, 0.1), {})) << "facing cameras";

  // Rays that part in front of the cameras and meet behind them.
  CameraCalibration left, right;
  left.fx_px = left.fy_px = right.fx_px = right.fy_px = 100;
  right.world_from_camera.translation = {1, 0, 0};
  const Camera a(left), b(right);
  const std::vector<Observation> parting{{&a, {-0.2, 0}, Eigen::Matrix2d::Identity()},
                                         {&b, {0.2, 0}, Eigen::Matrix2d::Identity()}};
  EXPECT_FALSE(triangulate(parting, {})) << "behind the cameras";
}

}  // namespace
}  // namespace glint
