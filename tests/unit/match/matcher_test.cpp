// SPDX-License-Identifier: MIT
// What every match must fulfil, whatever the scene.
#include "host/match/matcher.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "host/base/error.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

MatchOptions test_options() {
  MatchOptions options;
  options.sigma_px = 0.1;
  options.max_range_m = 10.0;
  return options;
}

/// Positions, sorted, so that sets of points can be compared.
std::vector<Eigen::Vector3d> positions(const std::vector<Point>& points) {
  std::vector<Eigen::Vector3d> list;
  for (const Point& p : points) list.push_back(p.position_in_world);
  std::sort(list.begin(), list.end(), [](const auto& a, const auto& b) { return a.x() < b.x(); });
  return list;
}

void expect_same(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_LT((a[k] - b[k]).norm(), 1e-7);
}

TEST(Matcher, EveryBlobIsUsedAtMostOnceAndFitsItsPoint) {
  const Calibration rig = ring_rig(4);
  const MatchOptions options = test_options();
  Matcher matcher(rig, options);
  std::mt19937_64 random(41);
  std::vector<Point> points;
  for (int frame = 0; frame < 50; ++frame) {
    const Exposure exposure =
        expose(rig, clustered(random, 40), {.centroid_px = 0.1, .missing = 0.1, .clutter = 10}, random);
    MatchCounters counters;
    matcher.match(exposure.spans(), {}, points, counters);
    std::vector<std::vector<int>> uses;
    for (const auto& list : exposure.blobs) uses.emplace_back(list.size(), 0);
    std::uint64_t blobs = 0, used = 0;
    for (const Point& point : points) {
      unsigned views = 0;
      double squares = 0.0;
      for (std::size_t c = 0; c < kMatchCameras; ++c) {
        if (point.blob_of_camera[c] < 0) continue;
        ASSERT_LT(c, rig.cameras.size());
        const auto index = static_cast<std::size_t>(point.blob_of_camera[c]);
        ASSERT_LT(index, exposure.blobs[c].size());
        ++uses[c][index];
        ++views;
        const CameraCalibration& k = rig.cameras[c];
        const auto& blob = exposure.blobs[c][index];
        const Eigen::Vector2d measured(k.fx_px * static_cast<double>(blob.x_undist) + k.cx_px,
                                       k.fy_px * static_cast<double>(blob.y_undist) + k.cy_px);
        const double residual = (*Camera(k).project_pinhole(point.position_in_world) - measured).norm();
        EXPECT_LT(residual, options.gate_px);
        squares += residual * residual;
      }
      EXPECT_EQ(views, point.views);
      EXPECT_GE(views, 2u);
      EXPECT_NEAR(std::sqrt(squares / views), point.rms_px, 1e-6);
      EXPECT_GT(point.covariance_m2.determinant(), 0.0);
      EXPECT_EQ(point.predicted_by, TrackId{});
      used += views;
    }
    for (std::size_t c = 0; c < uses.size(); ++c) {
      blobs += uses[c].size();
      for (int n : uses[c]) EXPECT_LE(n, 1);
    }
    EXPECT_EQ(counters.blobs, blobs);
    EXPECT_EQ(counters.points, points.size());
    EXPECT_EQ(counters.unmatched_blobs, blobs - used);
    EXPECT_EQ(counters.components, counters.exact + counters.inexact);
  }
}

TEST(Matcher, OrderOfBlobsDoesNotMatter) {
  const Calibration rig = ring_rig(4);
  Matcher matcher(rig, test_options());
  std::mt19937_64 random(42);
  std::vector<Point> points;
  MatchCounters counters;
  for (int frame = 0; frame < 30; ++frame) {
    Exposure exposure =
        expose(rig, scattered(random, 40), {.centroid_px = 0.1, .missing = 0.1, .clutter = 5}, random);
    matcher.match(exposure.spans(), {}, points, counters);
    const auto before = positions(points);
    for (auto& list : exposure.blobs) std::shuffle(list.begin(), list.end(), random);
    matcher.match(exposure.spans(), {}, points, counters);
    expect_same(positions(points), before);
  }
}

TEST(Matcher, OrderOfCamerasDoesNotMatter) {
  const Calibration rig = ring_rig(5);
  Matcher matcher(rig, test_options());
  std::mt19937_64 random(43);
  std::vector<Point> points;
  MatchCounters counters;
  for (int frame = 0; frame < 30; ++frame) {
    const Exposure exposure =
        expose(rig, scattered(random, 40), {.centroid_px = 0.1, .missing = 0.1, .clutter = 5}, random);
    matcher.match(exposure.spans(), {}, points, counters);
    const auto before = positions(points);
    std::vector<std::size_t> order(rig.cameras.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::shuffle(order.begin(), order.end(), random);
    Calibration shuffled;
    std::vector<std::span<const shaders::BlobRecord>> blobs;
    for (std::size_t c : order) {
      shuffled.cameras.push_back(rig.cameras[c]);
      blobs.emplace_back(exposure.blobs[c]);
    }
    Matcher other(shuffled, test_options());
    other.match(blobs, {}, points, counters);
    expect_same(positions(points), before);
  }
}

TEST(Matcher, PredictionsClaimTheirBlobsWhateverTheirOrder) {
  const Calibration rig = ring_rig(4);
  Matcher matcher(rig, test_options());
  std::mt19937_64 random(44);
  std::vector<Point> points;
  for (int frame = 0; frame < 30; ++frame) {
    // Pairs of markers 8 mm apart: a few pixels, so that each prediction finds the other's blobs too.
    auto markers = scattered(random, 10);
    for (std::size_t k = 0; k < 10; ++k)
      markers.push_back(markers[k] +
                        0.008 *
                            Eigen::Vector3d(uniform(random, -1, 1), uniform(random, -1, 1), 1).normalized());
    std::vector<Prediction> predictions;
    std::normal_distribution<double> off(0.0, 0.001);
    for (std::size_t k = 0; k < markers.size(); ++k)
      predictions.push_back({TrackId{static_cast<std::uint32_t>(k + 1)},
                             markers[k] + Eigen::Vector3d(off(random), off(random), off(random)),
                             1e-6 * Eigen::Matrix3d::Identity()});
    std::shuffle(predictions.begin(), predictions.end(), random);
    const Exposure exposure = expose(rig, markers, {.centroid_px = 0.05, .missing = 0.1}, random);
    MatchCounters counters;
    matcher.match(exposure.spans(), predictions, points, counters);
    std::size_t predicted = 0;
    for (const Point& point : points) {
      if (point.predicted_by == TrackId{}) continue;
      ++predicted;
      EXPECT_LT((point.position_in_world - markers[number(point.predicted_by) - 1]).norm(), 2e-3);
    }
    EXPECT_GE(predicted, 18u);
    EXPECT_LE(predicted, markers.size());
  }
}

TEST(Matcher, APredictionWithoutItsMarkerClaimsNothing) {
  const Calibration rig = ring_rig(4);
  Matcher matcher(rig, test_options());
  std::mt19937_64 random(45);
  const std::vector<Eigen::Vector3d> markers{{0.3, 0.2, 1.0}};
  const Exposure exposure = expose(rig, markers, {}, random);
  const std::vector<Prediction> predictions{
      {TrackId{7}, {-0.5, 0.1, 0.7}, 1e-6 * Eigen::Matrix3d::Identity()},
      {TrackId{8}, {0, 0, 0}, Eigen::Matrix3d::Constant(NAN)}};
  std::vector<Point> points;
  MatchCounters counters;
  matcher.match(exposure.spans(), predictions, points, counters);
  ASSERT_EQ(points.size(), 1u);
  EXPECT_EQ(points[0].predicted_by, TrackId{});
  EXPECT_EQ(points[0].views, 4u);
}

TEST(Matcher, FacingCamerasMakeNoGarbage) {
  // Two pairs that face each other exactly: near the lines between them a pair alone gives no depth.
  Calibration rig = ring_rig(4);
  for (std::size_t c = 0; c < 4; ++c) {
    const double angle = M_PI / 2 * static_cast<double>(c);
    rig.cameras[c].world_from_camera =
        looking_at({3.5 * std::cos(angle), 3.5 * std::sin(angle), 1.0}, {0, 0, 1});
  }
  Matcher matcher(rig, test_options());
  std::mt19937_64 random(46);
  Score total;
  std::vector<Point> points;
  MatchCounters counters;
  for (int frame = 0; frame < 200; ++frame) {
    auto markers = scattered(random, 12);
    markers[0] = {uniform(random, -1, 1), 0.001, 1.0};  // on a line
    const Exposure exposure = expose(rig, markers, {.centroid_px = 0.05}, random);
    matcher.match(exposure.spans(), {}, points, counters);
    total += score(exposure, markers, points);
  }
  EXPECT_EQ(total.ghosts, 0u);
  EXPECT_GE(total.recall(), 0.999);

  // The facing pair alone: what is on the line between the two is not a point.
  Calibration pair;
  pair.cameras = {rig.cameras[0], rig.cameras[2]};
  Matcher alone(pair, test_options());
  const Exposure exposure =
      expose(pair, {{0.4, 0.0, 1.0}, {-0.2, 0.001, 1.0}}, {.centroid_px = 0.05}, random);
  alone.match(exposure.spans(), {}, points, counters);
  EXPECT_TRUE(points.empty());
}

TEST(Matcher, RangesAndMinimumOfCamerasHold) {
  const Calibration rig = ring_rig(4);
  std::mt19937_64 random(47);
  const Exposure exposure = expose(rig, scattered(random, 20), {.centroid_px = 0.05, .missing = 0.2}, random);
  std::vector<Point> points;
  MatchCounters counters;
  MatchOptions options = test_options();
  options.min_cameras = 4;
  Matcher(rig, options).match(exposure.spans(), {}, points, counters);
  EXPECT_FALSE(points.empty());
  for (const Point& p : points) EXPECT_EQ(p.views, 4u);
  options = test_options();
  options.min_range_m = 4.0;
  Matcher(rig, options).match(exposure.spans(), {}, points, counters);
  for (const Point& p : points)
    for (std::size_t c = 0; c < 4; ++c)
      if (p.blob_of_camera[c] >= 0) {
        EXPECT_GE((p.position_in_world - rig.cameras[c].world_from_camera.translation).norm(), 4.0);
      }
}

TEST(Matcher, EmptyAndHopelessInputIsFine) {
  std::vector<Point> points;
  MatchCounters counters;
  Matcher none(Calibration{}, test_options());
  none.match({}, {}, points, counters);
  EXPECT_TRUE(points.empty());
  const Calibration rig = ring_rig(3);
  Matcher matcher(rig, test_options());
  const std::vector<shaders::BlobRecord> same(50, blob_at(rig.cameras[0], {640, 400}));
  matcher.match(std::vector<std::span<const shaders::BlobRecord>>{{}, {}, {}}, {}, points, counters);
  EXPECT_TRUE(points.empty());
  matcher.match(std::vector<std::span<const shaders::BlobRecord>>{same, {}, {}}, {}, points, counters);
  EXPECT_TRUE(points.empty());
  // Fifty blobs on one spot in every camera: at most fifty points, and no endless search.
  matcher.match(std::vector<std::span<const shaders::BlobRecord>>{same, same, same}, {}, points, counters);
  EXPECT_LE(points.size(), 75u);
}

TEST(Matcher, OptionsSayWhatIsWrong) {
  MatchOptions options;
  std::vector<std::string> problems;
  options.check(problems);
  EXPECT_TRUE(problems.empty());
  options.sigma_px = 0;
  options.gate_px = -1;
  options.min_cameras = 1;
  options.marker_radius_m = -1;
  options.min_range_m = 0;
  options.max_range_m = 0;
  options.check(problems);
  EXPECT_EQ(problems.size(), 7u);
  EXPECT_THROW(Matcher(ring_rig(2), options), Error);
  EXPECT_THROW(Matcher(ring_rig(33), MatchOptions{}), Error);
}

}  // namespace
}  // namespace glint
