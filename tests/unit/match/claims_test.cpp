// SPDX-License-Identifier: MIT
// A track claims the blobs that agree with each other, whichever of its cameras was asked first.
#include "host/match/claims.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "host/geometry/sphere_bias.hpp"
#include "host/match/matcher.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

using Blobs = std::vector<std::vector<shaders::BlobRecord>>;

constexpr double kPrediction_sd_m = 0.015;  // a few pixels: every blob near the marker fits it alone
constexpr int kDirections = 12;

class Claimed : public ::testing::Test {
 protected:
  Claimed() : rig_(ring_rig(4, 3.5)) {
    options_.max_range_m = 10.0;
    options_.marker_radius_m = 0.0063;
    matcher_ = std::make_unique<Matcher>(rig_, options_);
  }

  /// One bright, whole, round marker in every camera, so that the blobs' covariances are small.
  Blobs good_blobs() const {
    constexpr double kGrey = 150.0, kLimit_grey = 22.0;
    Blobs blobs;
    for (const CameraCalibration& c : rig_.cameras) {
      const Camera camera(c);
      const double depth = camera.in_camera(marker_).z(),
                   radius = c.fx_px * options_.marker_radius_m / depth + 0.3;
      const Eigen::Vector2d centre(c.cx_px, c.cy_px);
      const double outwards = sphere_bias_factor(options_.marker_radius_m, depth);
      shaders::BlobRecord blob = blob_at(c, centre + outwards * (*camera.project_pinhole(marker_) - centre));
      blob.area_px = static_cast<std::uint32_t>(std::lround(M_PI * radius * radius));
      blob.weight = static_cast<std::uint32_t>(kGrey) * blob.area_px;
      blob.sum = blob.weight + static_cast<std::uint32_t>(kLimit_grey) * blob.area_px;
      blob.peak = static_cast<std::uint32_t>(kGrey + kLimit_grey);
      blob.var_xx_px2 = blob.var_yy_px2 = static_cast<float>(radius * radius / 4);
      blobs.push_back({blob});
    }
    return blobs;
  }

  Blobs with_one_wrong(std::size_t camera, int direction, double by_px) const {
    Blobs blobs = good_blobs();
    const double angle = 2.0 * std::numbers::pi * direction / kDirections;
    blobs[camera][0].x_undist += static_cast<float>(by_px * std::cos(angle) / rig_.cameras[camera].fx_px);
    blobs[camera][0].y_undist += static_cast<float>(by_px * std::sin(angle) / rig_.cameras[camera].fy_px);
    return blobs;
  }

  const std::vector<Point>& match(const Blobs& blobs, const Eigen::Vector3d& expected) {
    const Prediction prediction{TrackId{3}, expected,
                                kPrediction_sd_m * kPrediction_sd_m * Eigen::Matrix3d::Identity()};
    MatchCounters counters;
    matcher_->match(std::vector<std::span<const shaders::BlobRecord>>(blobs.begin(), blobs.end()),
                    {&prediction, 1}, points_, counters);
    return points_;
  }

  Calibration rig_;
  MatchOptions options_;
  std::unique_ptr<Matcher> matcher_;
  std::vector<Point> points_;
  const Eigen::Vector3d marker_{0.4, -0.3, 1.2};
};

TEST_F(Claimed, GoodBlobsHaveSmallCovariances) {
  const auto& points = match(good_blobs(), marker_ + Eigen::Vector3d(0.01, -0.008, 0.012));
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].predicted_by, TrackId{3});
  EXPECT_EQ(points[0].views, 4u);
  for (std::size_t camera = 0; camera < 4; ++camera) EXPECT_LT(points[0].noise_px2[camera], 0.03 * 0.03);
  EXPECT_LT((points[0].position_in_world - marker_).norm(), 2e-6);
}

TEST_F(Claimed, AWrongViewDoesNotKeepTheRightOnesOut) {
  std::mt19937_64 random(51);
  std::normal_distribution<double> off(0.0, kPrediction_sd_m);
  for (std::size_t wrong = 0; wrong < 4; ++wrong)
    for (int direction = 0; direction < kDirections; ++direction) {
      SCOPED_TRACE(::testing::Message() << "camera " << wrong << ", direction " << direction);
      const Eigen::Vector3d expected = marker_ + Eigen::Vector3d(off(random), off(random), off(random));
      const auto& points = match(with_one_wrong(wrong, direction, 0.5), expected);
      ASSERT_EQ(points.size(), 1u);
      EXPECT_EQ(points[0].predicted_by, TrackId{3});
      EXPECT_EQ(points[0].views, 3u);
      for (std::size_t camera = 0; camera < 4; ++camera)
        EXPECT_EQ(points[0].blob_of_camera[camera], camera == wrong ? -1 : 0);
      EXPECT_LT((points[0].position_in_world - marker_).norm(), 1e-4);
    }
}

}  // namespace
}  // namespace glint
