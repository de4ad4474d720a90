// SPDX-License-Identifier: MIT
// Made-up poses against the truth of tumbling bodies.
#include <gtest/gtest.h>

#include "host/sim/pose_score.hpp"

namespace glint {
namespace {

SimOptions three_bodies(bool identical) {
  SimOptions options;
  options.motion = SimMotion::Tumbling;
  options.bodies.count = 3;
  options.bodies.identical = identical;
  options.markers = 15;
  return options;
}

std::vector<ScoredPose> truth_of(const Scene& scene, std::uint64_t tick) {
  TickTruth truth;
  scene.truth(tick, truth);
  std::vector<ScoredPose> poses;
  for (std::uint32_t b = 0; b < scene.bodies(); ++b) poses.push_back({b, truth.world_from_body[b]});
  return poses;
}

TEST(PoseScore, OfTheTruthIsPerfect) {
  const Scene scene(three_bodies(false));
  PoseScore score(scene);
  for (std::uint64_t tick = 0; tick < 20; ++tick) score.add(tick, truth_of(scene, tick));
  const PoseResult result = score.result();
  EXPECT_EQ(result.poses, 60u);
  EXPECT_GT(result.expected, 50u);
  EXPECT_EQ(result.recall, 1.0);
  EXPECT_EQ(result.astray + result.silent_swaps + result.ambiguous, 0u);
  EXPECT_LT(result.max_m, 1e-12);
  EXPECT_LT(result.max_rad, 1e-7);
}

TEST(PoseScore, MeasuresPlaceAndTurn) {
  const Scene scene(three_bodies(false));
  PoseScore score(scene);
  std::vector<ScoredPose> poses = truth_of(scene, 0);
  poses[0].world_from_body.translation += Eigen::Vector3d(0.003, 0.0, 0.004);
  poses[1].world_from_body.rotation =
      Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()) * poses[1].world_from_body.rotation;
  poses[2].world_from_body.translation.z() += 5.0;
  score.add(0, poses);
  const PoseResult result = score.result();
  EXPECT_EQ(result.astray, 1u);
  EXPECT_NEAR(result.rms_m, 0.005 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(result.max_rad, 0.1, 1e-9);
  EXPECT_EQ(result.found + 1, result.expected);
}

TEST(PoseScore, CountsASilentSwapOnceEachWayAndNoneThatIsTold) {
  const Scene scene(three_bodies(false));
  PoseScore score(scene);
  const auto swapped = [&](std::uint64_t tick, bool told) {
    std::vector<ScoredPose> poses = truth_of(scene, tick);
    std::swap(poses[0].name, poses[1].name);
    poses[0].ambiguous = poses[1].ambiguous = told;
    return poses;
  };
  score.add(0, swapped(0, true));
  EXPECT_EQ(score.result().silent_swaps, 0u);
  EXPECT_EQ(score.result().ambiguous, 2u);
  score.add(1, truth_of(scene, 1));
  EXPECT_EQ(score.result().silent_swaps, 0u);
  score.add(2, swapped(2, false));
  score.add(3, swapped(3, false));
  EXPECT_EQ(score.result().silent_swaps, 2u);
}

TEST(PoseScore, NamesOfIdenticalBodiesAreTheTrackersOwn) {
  for (const bool identical : {true, false}) {
    const Scene scene(three_bodies(identical));
    PoseScore score(scene);
    for (std::uint64_t tick = 0; tick < 5; ++tick) {
      std::vector<ScoredPose> poses = truth_of(scene, tick);
      std::swap(poses[0].name, poses[2].name);
      score.add(tick, poses);
    }
    EXPECT_EQ(score.result().silent_swaps, identical ? 0u : 2u);
  }
}

TEST(PoseScore, PredictedPosesDoNotCount) {
  const Scene scene(three_bodies(false));
  PoseScore score(scene);
  std::vector<ScoredPose> poses = truth_of(scene, 0);
  poses[0].measured = false;
  score.add(0, poses);
  EXPECT_EQ(score.result().poses, 2u);
  EXPECT_EQ(score.result().found + 1, score.result().expected);
}

}  // namespace
}  // namespace glint
