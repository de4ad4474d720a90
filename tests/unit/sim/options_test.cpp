// SPDX-License-Identifier: MIT
// The simulated rig refuses options that make no sense, all of them at once.
#include "host/sim/options.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "host/base/error.hpp"
#include "host/sim/scene.hpp"

namespace glint {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

std::vector<std::string> problems_of(const SimOptions& options) {
  std::vector<std::string> problems;
  options.check(problems);
  return problems;
}

TEST(SimOptions, DefaultsAreFine) { EXPECT_THAT(problems_of({}), SizeIs(0)); }

TEST(SimOptions, EveryProblemIsListed) {
  SimOptions options;
  options.cameras = 33;
  options.rate_hz = 0.0;
  options.jpeg_quality = 101;
  options.faults.drop_rate = std::numeric_limits<double>::quiet_NaN();
  options.faults.bump = SimBump{40, 0, 0.1};
  options.faults.swap = SimSwap{1, 1, 0};
  options.faults.delay = SimDelay{0, 0, 2.0};
  EXPECT_THAT(problems_of(options), SizeIs(7));
  options.faults.swap = SimSwap{1, 33, 0};
  EXPECT_THAT(problems_of(options), SizeIs(7));
  options.faults.swap = SimSwap{1, 2, 0};
  EXPECT_THAT(problems_of(options), SizeIs(6));
}

TEST(SimOptions, MotionsHaveTheirOwnRules) {
  SimOptions options;
  options.motion = SimMotion::Wand;  // no places, so no markers
  EXPECT_THAT(problems_of(options), SizeIs(2));
  options.wand_m = {0.0, 0.5};
  options.markers = 2;
  options.person = true;
  EXPECT_THAT(problems_of(options), SizeIs(0));
  options.motion = SimMotion::Thrown;  // neither wand nor person
  EXPECT_THAT(problems_of(options), SizeIs(2));

  options = {};
  options.motion = SimMotion::Pairs;
  options.markers = 7;
  EXPECT_THAT(problems_of(options), SizeIs(1));

  options = {};
  options.motion = SimMotion::Tumbling;
  options.bodies.count = 3;
  EXPECT_THAT(problems_of(options), SizeIs(1));  // 20 markers are not three times 5
  options.markers = 15;
  EXPECT_THAT(problems_of(options), SizeIs(0));
  options.motion = SimMotion::Crossing;
  EXPECT_THAT(problems_of(options), SizeIs(1));
  options.bodies.count = 2;
  options.markers = 10;
  EXPECT_THAT(problems_of(options), SizeIs(0));
  options.bodies.closest_m = 0.01;  // less than a marker's diameter
  options.bodies.crossing_period_s = 0.0;
  EXPECT_THAT(problems_of(options), SizeIs(2));
}

TEST(SimOptions, FaultsOfMarkersCamerasAndPixelsAreChecked) {
  SimOptions options;
  options.faults.missing_rate = 1.5;
  options.faults.blinks_per_frame = -1.0;
  options.faults.off = {{3, 10, 10}, {4, 10, 10}};
  EXPECT_THAT(problems_of(options), SizeIs(3));
}

TEST(SimOptions, SceneThrowsWithTheReason) {
  SimOptions options;
  options.cameras = 0;
  try {
    const Scene scene(options);
    FAIL() << "accepted 0 cameras";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("sim.cameras must be 1 to 32"));
  }
}

}  // namespace
}  // namespace glint
