// SPDX-License-Identifier: MIT
// The watch allocates nothing after it was made, in peace, while it names a fault, and when that is over.
#include <gtest/gtest.h>

#include <random>

#include "host/health/camera_health.hpp"
#include "host/match/matcher.hpp"
#include "tests/support/allocations.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

TEST(HealthNoAllocation, FromTheFirstExposure) {
  const Calibration rig = ring_rig(4);
  Matcher matcher(rig, {});
  CameraHealth health(rig, {});
  std::mt19937_64 random(9);
  const auto markers = scattered(random, 20);
  Calibration bumped = rig;
  bumped.cameras[1].world_from_camera.rotation *=
      Eigen::Quaterniond(Eigen::AngleAxisd(0.005, Eigen::Vector3d::UnitX()));
  std::vector<Point> points;
  std::vector<WatchedMarker> watched;
  MatchCounters counters;
  std::size_t allocated = 0;
  std::vector<CameraCondition> conditions;
  for (int frame = 0; frame < 450; ++frame) {
    const bool turned = frame >= 90 && frame < 270;
    const Exposure exposure = expose(turned ? bumped : rig, markers, {.centroid_px = 0.03}, random);
    const auto blobs = exposure.spans();
    matcher.match(blobs, {}, points, counters);
    watched.clear();
    for (std::uint32_t k = 0; k < points.size(); ++k) watched.push_back({k, Eigen::Vector3d::Zero()});
    const std::size_t before = allocations();
    health.watch({Timestamp(std::chrono::microseconds(11111 * frame)), 0xfu, blobs, points, watched});
    allocated += allocations() - before;
    for (const HealthEvent& event : health.events()) {
      conditions.push_back(event.state.condition);
      EXPECT_EQ(event.camera, CameraId{1});
    }
  }
  EXPECT_GT(allocations(), 0u) << "the counter does not count";
  EXPECT_EQ(allocated, 0u);
  EXPECT_EQ(conditions, (std::vector{CameraCondition::Bumped, CameraCondition::Fine}));
  EXPECT_EQ(health.state(CameraId{1}).condition, CameraCondition::Fine);
  EXPECT_FALSE(health.report().cameras[1].green()) << "it was bumped for a while";
}

}  // namespace
}  // namespace glint
