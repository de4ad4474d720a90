// SPDX-License-Identifier: MIT
// Touching markers that no track knows of are told apart by their pixels, and how noisy a camera's pixels are
// is learnt: on drawn images.
#include "host/match/pixel_look.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <memory>

#include "host/match/matcher.hpp"
#include "host/resolve/expected_disc.hpp"
#include "host/sim/backdrop.hpp"
#include "tests/unit/match/scene.hpp"
#include "tests/unit/resolve/drawn_discs.hpp"

namespace glint {
namespace {

using namespace testing;

constexpr std::uint32_t kSide_px = 96;
constexpr double kRadius_m = 0.012, kGrey = 180.0;  // 3 px
const Eigen::Vector3d kMiddle(0.0, 0.0, 0.8);       // what ring_rig() looks at

/// Images of what is within 0.15 m of the middle and no more, since drawing takes long.
Calibration close_up_rig(std::size_t cameras) {
  Calibration rig = ring_rig(cameras, 3.5);
  for (CameraCalibration& c : rig.cameras) {
    c.width_px = c.height_px = kSide_px;
    c.cx_px = c.cy_px = 0.5 * (kSide_px - 1);
  }
  return rig;
}

MatchOptions close_up_options() {
  MatchOptions options;
  options.max_range_m = 10.0;
  options.marker_radius_m = kRadius_m;
  return options;
}

struct Sensor {
  PixelNoise noise;
  double dark_grey = 10.0, limit_above_dark_grey = 12.0;
};

/// Still markers before noisy cameras, and the blobs of each exposure.
class StillLife {
 public:
  StillLife(const Calibration& rig, const std::vector<Eigen::Vector3d>& markers,
            const std::vector<Sensor>& sensors)
      : sensors_(sensors) {
    std::vector<gpu::CameraFormat> formats;
    for (std::size_t k = 0; k < rig.cameras.size(); ++k) {
      const CameraCalibration& c = rig.cameras[k];
      const Sensor& sensor = sensors[k];
      formats.push_back({c.width_px, c.height_px, {c.fx_px, c.fy_px, c.cx_px, c.cy_px, {}}});
      std::vector<TrueDisc> discs;
      for (const Eigen::Vector3d& marker : markers) {
        const auto seen = expected_disc(Camera(c), marker, Eigen::Vector3d::Zero(), kRadius_m, 0.0);
        TrueDisc& disc = discs.emplace_back(round_disc(seen->centre_px, 1.0, kGrey, seen->distance_m));
        disc.shape_px2 = seen->shape_px2;
      }
      drawn_.push_back(draw(kSide_px, kSide_px, sensor.dark_grey, discs, sensor.noise, random_, normal_));
    }
    for (const DrawnImage& image : drawn_) images_.push_back(image.view());
    detector_ = gpu::make_reference_detector(formats, {});
    for (std::uint32_t k = 0; k < sensors.size(); ++k) {
      const double limit = sensors[k].dark_grey + sensors[k].limit_above_dark_grey;
      detector_->set_limit(k,
                           std::vector<std::uint8_t>(kSide_px * kSide_px, static_cast<std::uint8_t>(limit)));
    }
  }

  /// The same light with other noise.
  void expose() {
    for (std::size_t k = 0; k < drawn_.size(); ++k)
      for (std::size_t i = 0; i < drawn_[k].mean.size(); ++i) {
        const double mean = drawn_[k].mean[i];
        const double light = mean - sensors_[k].dark_grey;
        const double sd = std::sqrt(sensors_[k].noise.variance_grey2(light) - 1.0 / 12.0);  // see draw()
        drawn_[k].pixels[i] =
            sim::to_pixel(static_cast<float>(mean + sd * static_cast<double>(normal_.draw(random_))));
      }
    gpu::BlobBatch batch;
    ASSERT_EQ(detector_->submit(images_), gpu::RunStatus::Ok);
    ASSERT_EQ(detector_->collect(batch), gpu::RunStatus::Ok);
    blobs_.clear();
    for (const gpu::CameraBlobs& list : batch.cameras)
      blobs_.emplace_back(list.blobs.begin(), list.blobs.end());
  }

  std::span<const gpu::ImageView> images() const { return images_; }
  std::vector<std::span<const shaders::BlobRecord>> blobs() const { return {blobs_.begin(), blobs_.end()}; }

 private:
  std::vector<Sensor> sensors_;
  sim::Random random_{61};
  sim::NormalTable normal_;
  std::vector<DrawnImage> drawn_;
  std::vector<gpu::ImageView> images_;
  std::unique_ptr<gpu::Detector> detector_;
  std::vector<std::vector<shaders::BlobRecord>> blobs_;
};

/// One above the other and a little aside, so that all cameras see them side by side.
std::vector<Eigen::Vector3d> touching(double apart_radii, int turn) {
  const double angle = 0.3 + 1.6 * turn;
  const Eigen::Vector3d along(0.2 * std::cos(angle), 0.2 * std::sin(angle), std::sqrt(1.0 - 0.04));
  const Eigen::Vector3d half = 0.5 * apart_radii * kRadius_m * along;
  return {kMiddle - half, kMiddle + half};
}

constexpr std::array kTouching_radii{1.8, 2.0, 2.2};
constexpr int kTurns = 4;

TEST(PixelLook, TouchingMarkersThatNobodyExpectsAreToldApart) {
  for (const std::size_t cameras : {3u, 4u, 5u}) {
    const Calibration rig = close_up_rig(cameras);
    Matcher matcher(rig, close_up_options());
    double worst_m = 0.0;
    for (const double apart : kTouching_radii)
      for (int turn = 0; turn < kTurns; ++turn) {
        SCOPED_TRACE(::testing::Message() << cameras << " cameras, " << apart << " radii, turn " << turn);
        const std::vector<Eigen::Vector3d> markers = touching(apart, turn);
        StillLife scene(rig, markers, std::vector<Sensor>(cameras));
        scene.expose();
        for (const auto& list : scene.blobs()) ASSERT_EQ(list.size(), 1u);  // they do touch
        std::vector<Point> points;
        MatchCounters counters;
        matcher.match(scene.blobs(), {}, points, counters, scene.images());
        EXPECT_EQ(counters.resolved, cameras);
        ASSERT_EQ(points.size(), 2u);
        for (const Eigen::Vector3d& marker : markers) {
          const double off = std::min((points[0].position_in_world - marker).norm(),
                                      (points[1].position_in_world - marker).norm());
          EXPECT_LT(off, 3e-4);
          worst_m = std::max(worst_m, off);
        }
        for (const Point& p : points) EXPECT_GE(p.views, 3u);
      }
    std::printf("%zu cameras: touching markers found to %.2f mm at worst\n", cameras, 1e3 * worst_m);
  }
}

TEST(PixelLook, WithoutImagesTouchingMarkersStayOne) {
  const Calibration rig = close_up_rig(4);
  Matcher matcher(rig, close_up_options());
  for (const double apart : kTouching_radii)
    for (int turn = 0; turn < kTurns; ++turn) {
      const std::vector<Eigen::Vector3d> markers = touching(apart, turn);
      StillLife scene(rig, markers, std::vector<Sensor>(4));
      scene.expose();
      std::vector<Point> points;
      MatchCounters counters;
      matcher.match(scene.blobs(), {}, points, counters);
      EXPECT_LE(points.size(), 1u);
      for (const Point& p : points)
        for (const Eigen::Vector3d& marker : markers)
          EXPECT_GT((p.position_in_world - marker).norm(), 0.3 * kRadius_m);
    }
}

/// Mean variance of the blobs of each camera, by their centroids alone: the images are not looked at.
std::vector<double> centroid_noise_px2(Matcher& matcher, const StillLife& scene,
                                       std::span<const Prediction> predictions) {
  std::vector<Point> points;
  MatchCounters counters;
  matcher.match(scene.blobs(), predictions, points, counters);
  std::vector<double> mean(scene.images().size(), 0.0);
  EXPECT_EQ(points.size(), predictions.size());
  for (const Point& p : points) {
    EXPECT_EQ(p.views, mean.size());
    EXPECT_EQ(p.resolved, 0u);
    for (std::size_t k = 0; k < mean.size(); ++k)
      mean[k] += static_cast<double>(p.noise_px2[k]) / static_cast<double>(points.size());
  }
  return mean;
}

TEST(PixelLook, NoiseOfACameraIsLearntFromItsMarkers) {
  constexpr std::size_t kNoisy = 1;
  constexpr int kMarkers = 6, kExposures = 48;
  Calibration rig = close_up_rig(4);
  for (CameraCalibration& c : rig.cameras) c.rms_px = 0.2;  // noisy blobs are within the gates from the start
  std::vector<Sensor> sensors(4);
  sensors[kNoisy].noise.read_noise_grey = 8.0;
  sensors[kNoisy].dark_grey = 40.0;  // that much noise would be cut off at 0
  sensors[kNoisy].limit_above_dark_grey = 30.0;

  std::vector<Eigen::Vector3d> markers;
  std::vector<Prediction> predictions;
  for (int k = 0; k < kMarkers; ++k) {  // a steep spiral: no camera sees two of them touch
    const double angle = 2.0 * k;
    markers.push_back(kMiddle +
                      Eigen::Vector3d(0.02 * std::cos(angle), 0.02 * std::sin(angle), 0.055 * (k - 2.5)));
    predictions.push_back(
        {TrackId{static_cast<std::uint32_t>(k + 1)}, markers.back(), 2.5e-7 * Eigen::Matrix3d::Identity()});
  }
  StillLife scene(rig, markers, sensors);
  scene.expose();
  Matcher matcher(rig, close_up_options());
  const std::vector<double> before = centroid_noise_px2(matcher, scene, predictions);
  for (int exposure = 0; exposure < kExposures; ++exposure) {
    scene.expose();
    std::vector<Point> points;
    MatchCounters counters;
    matcher.match(scene.blobs(), predictions, points, counters, scene.images());
  }
  const std::vector<double> after = centroid_noise_px2(matcher, scene, predictions);
  for (std::size_t k = 0; k < 4; ++k) {
    std::printf("camera %zu: centroids' variance %.2e px^2 at first, %.2e then\n", k, before[k], after[k]);
    if (k == kNoisy) {
      EXPECT_GT(after[k], 10.0 * before[k]);
    } else {
      EXPECT_LT(after[k], 1.3 * before[k]);
    }
  }
}

}  // namespace
}  // namespace glint
