// SPDX-License-Identifier: MIT
// The score counts what it says.
#include "host/sim/score.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <vector>

#include "host/sim/random.hpp"

namespace glint {
namespace {

/// What a perfect tracker gives.
std::vector<ScoredPoint> perfect(const Scene& scene, std::uint64_t tick) {
  TickTruth truth;
  scene.truth(tick, truth);
  std::vector<ScoredPoint> points;
  for (std::uint32_t m = 0; m < scene.markers(); ++m) {
    const MarkerTruth& marker = truth.markers[m];
    if (std::popcount(marker.clean) >= 2) points.push_back({m + 1, marker.position_in_world, marker.clean});
  }
  return points;
}

TEST(Score, ThePerfectTrackerIsPerfect) {
  const Scene scene({});
  Score score(scene);
  for (std::uint64_t tick = 0; tick < 50; ++tick) score.add(tick, perfect(scene, tick));
  const ScoreResult result = score.result();
  EXPECT_EQ(result.ticks, 50u);
  EXPECT_EQ(result.recall, 1.0);
  EXPECT_EQ(result.ghosts, 0u);
  EXPECT_EQ(result.doubled, 0u);
  EXPECT_EQ(result.id_switches, 0u);
  EXPECT_EQ(result.rms_m, 0.0);
  EXPECT_EQ(result.ratio, 0.0);
  EXPECT_GT(result.bound_rms_m, 1e-5);
}

TEST(Score, NothingFoundIsRecallZero) {
  const Scene scene({});
  Score score(scene);
  score.add(0, {});
  EXPECT_EQ(score.result().recall, 0.0);
  EXPECT_GT(score.result().expected, 10u);
}

TEST(Score, GhostsDoublesAndSwitches) {
  const Scene scene({});
  Score score(scene);
  std::vector<ScoredPoint> points = perfect(scene, 0);
  score.add(0, points);
  points = perfect(scene, 1);
  points[3].id = 77;                                                                      // a switch
  points.push_back({78, points[0].position_in_world + Eigen::Vector3d(0, 0, 0.005), 3});  // a second point
  points.push_back({79, {5, 5, 5}, 3});                                                   // a ghost
  points.push_back({80, Eigen::Vector3d::Constant(std::nan("")), 3});                     // and another one
  score.add(1, points);
  const ScoreResult result = score.result();
  EXPECT_EQ(result.id_switches, 1u);
  EXPECT_EQ(result.doubled, 1u);
  EXPECT_EQ(result.ghosts, 2u);
  EXPECT_EQ(result.recall, 1.0);
  EXPECT_EQ(result.rms_m, 0.0);  // the nearer of two counts
}

TEST(Score, ErrorsAtTheBoundHaveRatioOne) {
  const Scene scene({});
  Score score(scene, {0.01, 1});
  PositionBound bound(scene);
  sim::Random random(5);
  const sim::NormalTable normal;
  TickTruth truth;
  for (std::uint64_t tick = 0; tick < 60; ++tick) {
    scene.truth(tick, truth);
    std::vector<ScoredPoint> points;
    for (std::uint32_t m = 0; m < scene.markers(); ++m) {
      const double variance = bound.variance_m2(truth, m);
      if (!std::isfinite(variance)) continue;
      const double sd = std::sqrt(variance / 3.0);
      const auto draw = [&] { return sd * static_cast<double>(normal.draw(random)); };
      const Eigen::Vector3d error(draw(), draw(), draw());
      points.push_back({m + 1, truth.markers[m].position_in_world + error, truth.markers[m].clean});
    }
    score.add(tick, points);
  }
  const ScoreResult result = score.result();
  EXPECT_NEAR(result.ratio, 1.0, 0.05);
  EXPECT_NEAR(result.median_ratio, 1.0, 0.05);
  EXPECT_NEAR(result.rms_m, result.bound_rms_m, 0.05 * result.bound_rms_m);
  EXPECT_GT(result.rms_m, result.median_m);
}

TEST(Score, MergedBlobsCountInTheErrorButNotAgainstTheBound) {
  const Scene scene({});
  Score score(scene);
  std::vector<ScoredPoint> points = perfect(scene, 0);
  points[0].cameras = 0xffu;  // used a camera in which the marker is not clean
  points[0].position_in_world.x() += 0.003;
  score.add(0, points);
  const ScoreResult result = score.result();
  EXPECT_GT(result.rms_m, 1e-4);
  EXPECT_EQ(result.rms_clean_m, 0.0);
  EXPECT_NEAR(result.max_m, 0.003, 1e-12);
}

}  // namespace
}  // namespace glint
