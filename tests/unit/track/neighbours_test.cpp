// SPDX-License-Identifier: MIT
// What one track has learnt of the calibration's errors helps another that begins beside it.
#include <gtest/gtest.h>

#include <algorithm>

#include "host/track/tracker.hpp"

namespace glint {
namespace {

using Eigen::Vector3d;
using std::chrono::microseconds;

constexpr double kCalibration_px = 0.35;
constexpr double kVariance_px2 = kCalibration_px * kCalibration_px;
constexpr float kNoise_px2 = 4e-4F;
constexpr std::size_t kCameras = 3;
constexpr std::size_t kHidden =
    2;  // the camera that a new marker is not seen by: it knows of it only by others
const Eigen::Vector2f kError_px(0.5F, -0.3F);  // that camera's, where the markers are

Point seen_by(std::size_t cameras, const Vector3d& position) {
  constexpr double kVariance_m2 = 1e-9;
  Point point;
  point.position_in_world = position;
  point.covariance_m2 = kVariance_m2 * Eigen::Matrix3d::Identity();
  point.information_per_m2 = Eigen::Matrix3d::Identity() / kVariance_m2;
  point.views = static_cast<std::uint32_t>(cameras);
  point.certain = true;
  point.blob_of_camera.fill(-1);
  point.residual_px.fill(Eigen::Vector2f::Zero());
  point.noise_px2.fill(0.0F);
  for (std::size_t camera = 0; camera < cameras; ++camera) {
    point.blob_of_camera[camera] = 0;
    point.noise_px2[camera] = kNoise_px2;
  }
  if (cameras > kHidden) point.residual_px[kHidden] = kError_px;
  return point;
}

class Neighbours : public ::testing::Test {
 protected:
  void expose(const std::vector<Point>& points) {
    now_ += microseconds(11111);
    tracker_.predict(Timestamp(now_), predictions_);
    tracker_.update(points, tracked_, counters_);
  }

  void learn(int exposures) {
    for (int k = 0; k < exposures; ++k) expose({seen_by(3, kHere)});
  }

  /// What the track that is nearest expects of the hidden camera at the next exposure.
  ViewBias expected_at(const Vector3d& position) {
    now_ += microseconds(11111);
    tracker_.predict(Timestamp(now_), predictions_);
    const auto nearest = std::min_element(
        predictions_.begin(), predictions_.end(), [&](const Prediction& a, const Prediction& b) {
          return (a.position_in_world - position).norm() < (b.position_in_world - position).norm();
        });
    EXPECT_LT((nearest->position_in_world - position).norm(), 0.01);
    EXPECT_EQ(nearest->bias.size(), kCameras);
    return nearest->bias[kHidden];
  }

  const Vector3d kHere{0.2, -0.1, 1.0};
  Tracker tracker_{TrackOptions{}, std::vector<double>(kCameras, kCalibration_px)};
  microseconds now_{1'000'000};
  std::vector<Prediction> predictions_;
  std::vector<TrackedPoint> tracked_;
  TrackCounters counters_;
};

TEST_F(Neighbours, ATrackLearnsTheCalibrationsErrorByItself) {
  learn(40);
  const ViewBias own = expected_at(kHere);
  EXPECT_LT((own.px - kError_px.cast<double>()).norm(), 0.01);
  EXPECT_LT(own.variance_px2, 0.01 * kVariance_px2);
}

TEST_F(Neighbours, OneThatBeginsBesideKnowsTheErrorFromTheFirst) {
  learn(40);
  const Vector3d beside = kHere + Vector3d(0.0, 0.05, 0.0);
  expose({seen_by(3, kHere), seen_by(2, beside)});
  EXPECT_EQ(tracked_.size(), 2u);
  const ViewBias bias = expected_at(beside);
  EXPECT_LT((bias.px - kError_px.cast<double>()).norm(), 0.05 * static_cast<double>(kError_px.norm()));
  EXPECT_LT(bias.variance_px2, 0.1 * kVariance_px2);
  // Yet not as well as one that has seen it: it is another place.
  EXPECT_GT(bias.variance_px2, 0.02 * kVariance_px2);
}

TEST_F(Neighbours, OneThatBeginsFarAwayKnowsOnlyTheCalibration) {
  learn(40);
  const Vector3d away = kHere + Vector3d(0.0, 2.0, 0.0);
  expose({seen_by(3, kHere), seen_by(2, away)});
  EXPECT_EQ(tracked_.size(), 2u);
  const ViewBias bias = expected_at(away);
  EXPECT_EQ(bias.px.norm(), 0.0);
  EXPECT_NEAR(bias.variance_px2, kVariance_px2, 1e-12);
}

TEST_F(Neighbours, TheNearestOfTwoIsBelieved) {
  const Vector3d beside = kHere + Vector3d(0.0, 0.05, 0.0), farther = kHere + Vector3d(0.0, 0.25, 0.0);
  Point other = seen_by(3, farther);
  other.residual_px[kHidden] = -kError_px;
  for (int k = 0; k < 40; ++k) expose({seen_by(3, kHere), other});
  expose({other, seen_by(3, kHere), seen_by(2, beside)});
  EXPECT_LT((expected_at(beside).px - kError_px.cast<double>()).norm(),
            0.05 * static_cast<double>(kError_px.norm()));
}

TEST_F(Neighbours, OneThatIsItselfNewOrUnseenIsNotAsked) {
  const Vector3d beside = kHere + Vector3d(0.0, 0.05, 0.0);
  expose({seen_by(3, kHere), seen_by(2, beside)});
  EXPECT_EQ(expected_at(beside).px.norm(), 0.0);
  EXPECT_NEAR(expected_at(beside).variance_px2, kVariance_px2, 1e-12);

  learn(40);  // the one beside ends
  expose({seen_by(2, beside)});
  EXPECT_EQ(expected_at(beside).px.norm(), 0.0);
}

TEST_F(Neighbours, WhatATrackHasSeenItselfCountsMore) {
  learn(40);
  const Vector3d beside = kHere + Vector3d(0.0, 0.05, 0.0);
  Point own = seen_by(3, beside);
  own.residual_px[kHidden] = -kError_px;
  for (int k = 0; k < 40; ++k) expose({seen_by(3, kHere), own});
  EXPECT_LT((expected_at(beside).px + kError_px.cast<double>()).norm(), 0.02);
  EXPECT_LT((expected_at(kHere).px - kError_px.cast<double>()).norm(), 0.02);
}

}  // namespace
}  // namespace glint
