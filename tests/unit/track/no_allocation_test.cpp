// SPDX-License-Identifier: MIT
// Matching and tracking do not allocate once they have seen such frames.
#include <gtest/gtest.h>

#include "host/track/tracker.hpp"
#include "tests/support/allocations.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

TEST(NoAllocation, AfterWarmUp) {
  const Calibration rig = ring_rig(4);
  MatchOptions options;
  options.max_range_m = 10.0;
  Matcher matcher(rig, options);
  Tracker tracker{TrackOptions{}};
  std::mt19937_64 random(9);
  const auto start = scattered(random, 20);
  std::vector<Eigen::Vector3d> velocity;
  for (std::size_t k = 0; k < start.size(); ++k)
    velocity.push_back({uniform(random, -3, 3), uniform(random, -3, 3), uniform(random, -1, 1)});
  std::vector<Exposure> exposures;
  for (int frame = 0; frame < 60; ++frame) {
    auto now = start;
    // There and back, so that the second half is no harder than the first.
    for (std::size_t k = 0; k < now.size(); ++k)
      now[k] += 0.3 * std::sin(frame * 0.1) * velocity[k].normalized();
    exposures.push_back(expose(rig, now, {.centroid_px = 0.03, .missing = 0.02}, random));
  }
  std::vector<std::vector<std::span<const shaders::BlobRecord>>> blobs;
  for (const Exposure& exposure : exposures) blobs.push_back(exposure.spans());
  std::vector<Prediction> predictions;
  std::vector<Point> points;
  std::vector<TrackedPoint> tracked;
  MatchCounters match_counters;
  TrackCounters track_counters;
  std::size_t shown = 0;
  const auto pass = [&](int round) {
    for (std::size_t frame = 0; frame < blobs.size(); ++frame) {
      const auto time = std::chrono::microseconds(11111) * (static_cast<long>(frame) + round * 60);
      tracker.predict(Timestamp(time), predictions);
      matcher.match(blobs[frame], predictions, points, match_counters);
      tracker.update(points, tracked, track_counters);
      shown += tracked.size();
    }
  };
  pass(0);
  pass(1);
  const std::size_t before = glint::testing::allocations();
  EXPECT_GT(before, 0u) << "the counter does not count";
  pass(2);
  EXPECT_EQ(glint::testing::allocations() - before, 0u);
  EXPECT_GT(shown, 3u * 60u * 18u);
}

}  // namespace
}  // namespace glint
