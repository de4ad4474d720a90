// SPDX-License-Identifier: MIT
// Merged, hidden and cut blobs must not pull points away from where the good blobs put them.
#include <gtest/gtest.h>

#include "host/geometry/sphere_bias.hpp"
#include "host/match/matcher.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

class OddBlobs : public ::testing::Test {
 protected:
  OddBlobs() : rig_(ring_rig(4, 3.5)) {
    options_.max_range_m = 10.0;
    options_.marker_radius_m = 0.0063;
  }

  /// A marker of the right size in all cameras, sphere bias included.
  std::vector<std::vector<shaders::BlobRecord>> blobs_of(const Eigen::Vector3d& marker) {
    std::vector<std::vector<shaders::BlobRecord>> blobs;
    for (const CameraCalibration& c : rig_.cameras) {
      const Camera camera(c);
      const double depth = camera.in_camera(marker).z(),
                   radius = c.fx_px * options_.marker_radius_m / depth + 0.3;
      Eigen::Vector2d pixel = *camera.project_pinhole(marker);
      const Eigen::Vector2d centre(c.cx_px, c.cy_px);
      pixel = centre + sphere_bias_factor(options_.marker_radius_m, depth) * (pixel - centre);
      shaders::BlobRecord blob = blob_at(c, pixel);
      blob.area_px = static_cast<std::uint32_t>(std::lround(M_PI * radius * radius));
      blob.var_xx_px2 = blob.var_yy_px2 = static_cast<float>(radius * radius / 4);
      blobs.push_back({blob});
    }
    return blobs;
  }
  void move(shaders::BlobRecord& blob, std::size_t camera, double dx_px, double dy_px) {
    blob.x_undist += static_cast<float>(dx_px / rig_.cameras[camera].fx_px);
    blob.y_undist += static_cast<float>(dy_px / rig_.cameras[camera].fy_px);
  }
  const std::vector<Point>& match(const std::vector<std::vector<shaders::BlobRecord>>& blobs,
                                  const std::vector<Prediction>& predictions = {}) {
    Matcher matcher(rig_, options_);
    counters_ = {};
    matcher.match(std::vector<std::span<const shaders::BlobRecord>>(blobs.begin(), blobs.end()), predictions,
                  points_, counters_);
    return points_;
  }

  Calibration rig_;
  MatchOptions options_;
  std::vector<Point> points_;
  MatchCounters counters_;
  const Eigen::Vector3d marker_{0.4, -0.3, 1.2};
};

TEST_F(OddBlobs, AllGood) {
  const auto& points = match(blobs_of(marker_));
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].views, 4u);
  EXPECT_LT((points[0].position_in_world - marker_).norm(), 2e-6);
}

TEST_F(OddBlobs, OneMergedBlobOfFourIsLeftOut) {
  for (double offset_px : {0.4, 0.8, 2.0, 5.0}) {
    auto blobs = blobs_of(marker_);
    move(blobs[2][0], 2, offset_px, 0.3 * offset_px);
    const auto& points = match(blobs);
    ASSERT_EQ(points.size(), 1u) << offset_px;
    EXPECT_EQ(points[0].views, 3u);
    EXPECT_EQ(points[0].blob_of_camera[2], -1);
    EXPECT_LT((points[0].position_in_world - marker_).norm(), 1e-5);
  }
}

TEST_F(OddBlobs, AnElongatedBlobCountsAcrossItsLengthOnly) {
  auto blobs = blobs_of(marker_);
  move(blobs[1][0], 1, 0.6, 0.0);
  blobs[1][0].var_xx_px2 += 2.0f;
  blobs[1][0].area_px *= 2;
  const auto& points = match(blobs);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_LT((points[0].position_in_world - marker_).norm(), 5e-5);
}

TEST_F(OddBlobs, OneOddBlobOfThreeIsFoundByTheOthersAgreeing) {
  // Nothing but the residuals tells: the blob looks right and lies 0.7 px off in a direction that the others
  // deny.
  for (std::size_t odd = 0; odd < 3; ++odd) {
    auto blobs = blobs_of(marker_);
    blobs[3].clear();
    move(blobs[odd][0], odd, 0.5, 0.5);
    const auto& points = match(blobs);
    ASSERT_EQ(points.size(), 1u);
    EXPECT_EQ(points[0].views, 2u);
    EXPECT_EQ(points[0].blob_of_camera[odd], -1);
    EXPECT_LT((points[0].position_in_world - marker_).norm(), 1e-4);
  }
}

TEST_F(OddBlobs, AHalfHiddenBlobWeighsLittle) {
  auto blobs = blobs_of(marker_);
  for (auto& list : blobs) list[0].area_px = 40;
  blobs[0][0].area_px = 14;
  move(blobs[0][0], 0, 0.15, 0.0);
  const auto& points = match(blobs);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_LT((points[0].position_in_world - marker_).norm(), 3e-5);
}

TEST_F(OddBlobs, TwoViewsOfWhichOneLooksMergedAreHeldBack) {
  auto blobs = blobs_of(marker_);
  blobs[2].clear();
  blobs[3].clear();
  EXPECT_EQ(match(blobs).size(), 1u);
  move(blobs[1][0], 1, 0.0, 0.0);
  blobs[1][0].var_xx_px2 += 3.0f;
  EXPECT_TRUE(match(blobs).empty());
  EXPECT_EQ(counters_.held_back, 1u);
}

TEST_F(OddBlobs, AViewThatLooksMergedSaysHowLittleItKnows) {
  auto blobs = blobs_of(marker_);
  blobs[2].clear();
  blobs[3].clear();
  move(blobs[1][0], 1, 0.8, 0.1);
  blobs[1][0].var_xx_px2 += 3.0f;
  const Eigen::Vector3d expected = marker_ + Eigen::Vector3d(1e-4, -1e-4, 1e-4);
  const std::vector<Prediction> predictions{{TrackId{5}, expected, 4e-8 * Eigen::Matrix3d::Identity()}};
  const auto& points = match(blobs, predictions);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].predicted_by, TrackId{5});
  // The track's expectation takes the place of the second view.
  const Eigen::Matrix3d prior = Eigen::Matrix3d::Identity() / 4e-8;
  const Eigen::Matrix3d posterior = (prior + points[0].information_per_m2).inverse();
  const Eigen::Vector3d both =
      points[0].position_in_world +
      posterior * (points[0].gradient_per_m + prior * (expected - points[0].position_in_world));
  EXPECT_LT((both - marker_).norm(), 3e-4);
  EXPECT_LT(posterior.trace(), 3 * 4e-8);
}

TEST_F(OddBlobs, WhatIsLeftOfAMergedBlobMakesNoGhost) {
  // Two markers that merge in cameras 0 and 1; both are clean in 2 and 3. The merged blobs meet near the
  // middle.
  const Eigen::Vector3d other = marker_ + Eigen::Vector3d(0.0, 0.0, 0.012);
  auto blobs = blobs_of(marker_);
  const auto second = blobs_of(other);
  for (std::size_t c : {0u, 1u}) {
    auto& blob = blobs[c][0];
    const double dy = static_cast<double>(second[c][0].y_undist - blob.y_undist) * rig_.cameras[c].fy_px;
    blob.x_undist = 0.5f * (blob.x_undist + second[c][0].x_undist);
    blob.y_undist = 0.5f * (blob.y_undist + second[c][0].y_undist);
    blob.var_yy_px2 += static_cast<float>(dy * dy / 4);
    blob.area_px *= 2;
  }
  for (std::size_t c : {2u, 3u}) blobs[c].push_back(second[c][0]);
  const auto& points = match(blobs);
  ASSERT_EQ(points.size(), 2u);
  for (const Point& p : points)
    EXPECT_LT(std::min((p.position_in_world - marker_).norm(), (p.position_in_world - other).norm()), 5e-4);
}

TEST_F(OddBlobs, BlobsThatAKnownPointExplainMakeNoGhost) {
  // Three cameras see the marker; two see it hidden in part, 5 mm off, and agree with each other about that.
  rig_ = ring_rig(5, 3.5);
  auto blobs = blobs_of(marker_);
  const auto shifted = blobs_of(marker_ + Eigen::Vector3d(0.0, 0.0, 0.005));
  blobs[0] = shifted[0];
  blobs[1] = shifted[1];
  const auto& points = match(blobs);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].views, 3u);
  EXPECT_LT((points[0].position_in_world - marker_).norm(), 1e-5);
  EXPECT_EQ(counters_.held_back, 1u);
}

TEST_F(OddBlobs, TheLoserOfASharedBlobKeepsItsOtherViews) {
  // In camera 0 the two markers stand one behind the other and give one blob, which fits both.
  const Eigen::Vector3d from = rig_.cameras[0].world_from_camera.translation;
  const Eigen::Vector3d behind = marker_ + 0.1 * (marker_ - from).normalized();
  auto blobs = blobs_of(marker_);
  const auto second = blobs_of(behind);
  for (std::size_t c = 1; c < 4; ++c) blobs[c].push_back(second[c][0]);
  options_.min_cameras = 3;
  EXPECT_EQ(match(blobs).size(), 2u);
  const std::vector<Prediction> predictions{{TrackId{1}, marker_, 1e-6 * Eigen::Matrix3d::Identity()},
                                            {TrackId{2}, behind, 1e-6 * Eigen::Matrix3d::Identity()}};
  const auto& points = match(blobs, predictions);
  ASSERT_EQ(points.size(), 2u);
  for (const Point& p : points) {
    EXPECT_NE(p.predicted_by, TrackId{});
    EXPECT_LT((p.position_in_world - (p.predicted_by == TrackId{1} ? marker_ : behind)).norm(), 1e-4);
  }
}

}  // namespace
}  // namespace glint
