// SPDX-License-Identifier: MIT
// Poses from views: exact, honest, robust, and with few views.
#include <gtest/gtest.h>

#include "host/body/body_pose_fit.hpp"
#include "host/body/point_pose.hpp"
#include "tests/unit/body/body_scene.hpp"

namespace glint {
namespace {

using namespace testing;

class PoseFit : public ::testing::Test {
 protected:
  /// Views of all markers where they truly are: the model's places with an error of their own.
  void look(const BodyModel& model, const Pose& pose, double sd_px, double missing = 0.0) {
    views.clear();
    for (std::uint32_t m = 0; m < model.markers_in_body.size(); ++m) {
      const Eigen::Vector3d at = pose * (model.markers_in_body[m] + normal3(random, model.marker_sd_m));
      for (const Observation& o : observe(cameras, at, sd_px, missing, random))
        views.push_back({o.camera, o.normalized, o.covariance_px2, m});
    }
    outlier.assign(views.size(), 0);
  }
  std::optional<BodyFit> fit(const BodyModel& model, const Pose& start, const PosePrior* prior = nullptr) {
    BodyFitOptions options;
    options.marker_sd_m = model.marker_sd_m;
    return fit_body_pose(model.markers_in_body, views, start, prior, options, outlier);
  }
  Pose disturbed(const Pose& pose, double turn_rad, double shift_m) {
    return {(rotation_of(normal3(random, turn_rad)) * pose.rotation).normalized(),
            pose.translation + normal3(random, shift_m)};
  }

  std::mt19937_64 random{5};
  std::vector<Camera> cameras = cameras_of(ring_rig(4));
  std::vector<BodyView> views;
  std::vector<std::uint8_t> outlier;
};

TEST_F(PoseFit, ClosedFormIsExactAndRefusesALine) {
  const BodyModel model = random_body(random, 4, "b");
  const Pose pose = random_pose(random);
  std::vector<Eigen::Vector3d> world;
  for (const auto& p : model.markers_in_body) world.push_back(pose * p);
  const auto found = pose_from_points(model.markers_in_body, world);
  ASSERT_TRUE(found);
  EXPECT_LT(pose_difference(*found, pose).norm(), 1e-9);
  const std::vector<Eigen::Vector3d> line{{0, 0, 0}, {1, 1, 1}, {3, 3, 3}};
  EXPECT_FALSE(pose_from_points(line, line));
}

TEST_F(PoseFit, WithoutNoiseItIsExactFromFarOff) {
  BodyModel model = random_body(random, 5, "b");
  model.marker_sd_m = 1e-9;
  const Pose pose = random_pose(random);
  look(model, pose, 1e-6);
  const auto found = fit(model, disturbed(pose, 0.3, 0.1));
  ASSERT_TRUE(found);
  EXPECT_LT(pose_difference(found->world_from_body, pose).norm(), 1e-6);
}

TEST_F(PoseFit, CovarianceIsHonest) {
  for (const bool with_prior : {false, true}) {
    const BodyModel model = random_body(random, 5, "b");
    double sum = 0.0, chi2 = 0.0, degrees = 0.0;
    const int runs = 1500;
    for (int run = 0; run < runs; ++run) {
      const Pose pose = random_pose(random);
      look(model, pose, 0.1, 0.2);
      PosePrior prior;
      prior.world_from_body = disturbed(pose, 0.002, 0.0003);
      prior.covariance = Matrix6::Zero();
      prior.covariance.diagonal() << 4e-6, 4e-6, 4e-6, 9e-8, 9e-8, 9e-8;
      const auto found = fit(model, with_prior ? prior.world_from_body : disturbed(pose, 0.05, 0.01),
                             with_prior ? &prior : nullptr);
      ASSERT_TRUE(found);
      const Vector6 error = pose_difference(found->world_from_body, pose);
      sum += error.dot(found->covariance.inverse() * error);
      chi2 += found->chi2 + (with_prior ? found->prior_chi2 : 0.0);
      degrees += 2.0 * found->views - (with_prior ? 0.0 : 6.0);
    }
    // Standard deviation of the mean of a chi-square of six degrees: sqrt(12 / runs) = 0.09.
    EXPECT_NEAR(sum / runs, 6.0, 0.36) << with_prior;
    EXPECT_NEAR(chi2 / degrees, 1.0, 0.03) << with_prior;
  }
}

TEST_F(PoseFit, WrongViewsAreFoundOut) {
  const BodyModel model = random_body(random, 6, "b");
  int exact = 0;
  double worst = 0.0;
  for (int run = 0; run < 300; ++run) {
    const Pose pose = random_pose(random);
    look(model, pose, 0.1);
    std::vector<std::uint8_t> wrong(views.size(), 0);
    for (std::size_t k = 0; k < views.size(); ++k)
      if (uniform(random, 0, 1) < 0.15) {
        wrong[k] = 1;
        const double angle = uniform(random, 0, 2 * M_PI), by = uniform(random, 3.0, 30.0) / 914.0;
        views[k].normalized += by * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      }
    const auto found = fit(model, disturbed(pose, 0.05, 0.01));
    ASSERT_TRUE(found);
    exact += outlier == wrong ? 1 : 0;
    worst = std::max(worst, pose_difference(found->world_from_body, pose).tail<3>().norm());
  }
  EXPECT_GE(exact, 290);
  EXPECT_LT(worst, 0.002);
}

TEST_F(PoseFit, ThreeMarkersInOneCameraWithAPrior) {
  const BodyModel model = random_body(random, 3, "b");
  cameras.erase(cameras.begin() + 1, cameras.end());
  double sum = 0.0;
  int narrowed = 0;
  const int runs = 500;
  for (int run = 0; run < runs; ++run) {
    const Pose pose = random_pose(random);
    look(model, pose, 0.1);
    PosePrior prior;
    prior.world_from_body = disturbed(pose, 0.05, 0.01);
    prior.covariance = Matrix6::Zero();
    prior.covariance.diagonal() << 25e-4, 25e-4, 25e-4, 1e-4, 1e-4, 1e-4;
    const auto found = fit(model, prior.world_from_body, &prior);
    ASSERT_TRUE(found);
    const Vector6 error = pose_difference(found->world_from_body, pose);
    sum += error.dot(found->covariance.inverse() * error);
    narrowed += found->covariance.trace() < 0.5 * prior.covariance.trace() ? 1 : 0;
  }
  EXPECT_NEAR(sum / runs, 6.0, 0.8);
  EXPECT_GT(narrowed, runs * 9 / 10);
}

TEST_F(PoseFit, TwoMarkersNeedAPrior) {
  const BodyModel model = random_body(random, 4, "b");
  const Pose pose = random_pose(random);
  look(model, pose, 0.1);
  std::erase_if(views, [](const BodyView& view) { return view.marker > 1; });
  outlier.resize(views.size());
  EXPECT_FALSE(fit(model, pose));
  PosePrior prior;
  prior.world_from_body = pose;
  prior.covariance = 1e-4 * Matrix6::Identity();
  const auto found = fit(model, pose, &prior);
  ASSERT_TRUE(found);
  // About the line through both nothing was learnt.
  const Eigen::Vector3d axis =
      pose.rotation * (model.markers_in_body[1] - model.markers_in_body[0]).normalized();
  const Eigen::Matrix3d turn = found->covariance.topLeftCorner<3, 3>();
  EXPECT_GT(axis.dot(turn * axis), 0.5e-4);
  EXPECT_LT(turn.trace() - axis.dot(turn * axis), 1e-4);
}

TEST_F(PoseFit, TheSpheresBiasIsRemoved) {
  BodyModel model = random_body(random, 5, "b");
  model.marker_sd_m = 1e-6;
  const Pose pose = random_pose(random);
  look(model, pose, 1e-4);
  const double radius_m = 0.02;
  for (BodyView& view : views) {
    const double z = view.camera->in_camera(pose * model.markers_in_body[view.marker]).z();
    view.normalized /= 1.0 - radius_m * radius_m / (z * z);
  }
  BodyFitOptions options;
  options.marker_sd_m = model.marker_sd_m;
  options.marker_radius_m = radius_m;
  const auto found = fit_body_pose(model.markers_in_body, views, pose, nullptr, options, outlier);
  ASSERT_TRUE(found);
  EXPECT_LT(pose_difference(found->world_from_body, pose).norm(), 1e-4);  // 2e-3 with the bias left in
}

}  // namespace
}  // namespace glint
