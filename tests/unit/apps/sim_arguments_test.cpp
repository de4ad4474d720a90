// SPDX-License-Identifier: MIT
// Words on the command line become the simulated rig that they ask for, or a message that says what to give.
#include "host/apps/sim_arguments.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/sim/rig.hpp"

namespace glint::apps {
namespace {

using testing::HasSubstr;

SimArguments parsed(std::vector<std::string> words) {
  SimArguments arguments;
  CLI::App app;
  std::string source;
  app.add_option("SOURCE", source);
  add_sim_options(app, arguments);
  std::reverse(words.begin(), words.end());
  app.parse(words);
  EXPECT_EQ(source, "sim");
  return arguments;
}

SimOptions options_of(const std::vector<std::string>& words) { return checked_sim_options(parsed(words)); }

std::string refusal_of(const std::vector<std::string>& words) {
  try {
    options_of(words);
  } catch (const UsageError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SimArguments, MotionsBringTheirMarkers) {
  EXPECT_EQ(options_of({"sim"}).motion, SimMotion::Thrown);
  EXPECT_EQ(options_of({"--motion", "thrown", "sim"}).markers, 20u);
  const SimOptions three = options_of({"--motion", "tumbling", "sim"});
  EXPECT_EQ(three.motion, SimMotion::Tumbling);
  EXPECT_EQ(three.markers, 15u);
  const SimOptions eight = options_of({"--motion", "tumbling", "--bodies", "8", "--body-size", "0.3", "sim"});
  EXPECT_EQ(eight.bodies.count, 8u);
  EXPECT_EQ(eight.markers, 40u);
  EXPECT_EQ(eight.bodies.size_m, 0.3);
  const SimOptions crossing = options_of({"--motion", "crossing", "--identical", "sim"});
  EXPECT_EQ(crossing.motion, SimMotion::Crossing);
  EXPECT_EQ(crossing.markers, 10u);
  EXPECT_TRUE(crossing.bodies.identical);
  EXPECT_EQ(options_of({"--motion", "pairs", "--markers", "8", "sim"}).motion, SimMotion::Pairs);
  const SimOptions rod = options_of({"--wave", "0,0.589", "--person", "sim"});
  EXPECT_EQ(rod.motion, SimMotion::Wand);
  EXPECT_EQ(rod.markers, 2u);
  EXPECT_TRUE(rod.person);
}

TEST(SimArguments, FaultsAreRead) {
  const SimOptions o =
      options_of({"--bump", "2:450:0.5", "--slip", "1:7:-3", "--swap", "2:3:9", "--delay", "4:5:8.5", "--off",
                  "1:90:45,3:200:10", "sim", "--missing-rate", "0.1", "--blinks", "0.5"});
  EXPECT_EQ(o.faults.bump->camera, 1u);
  EXPECT_EQ(o.faults.bump->tick, 450u);
  EXPECT_NEAR(o.faults.bump->angle_rad, 0.5 * std::numbers::pi / 180.0, 1e-15);
  EXPECT_EQ(o.faults.slip->pulses, -3);
  EXPECT_EQ(o.faults.swap->other, 2u);
  EXPECT_EQ(o.faults.delay->delay_s, 8.5e-3);
  ASSERT_EQ(o.faults.off.size(), 2u);
  EXPECT_EQ(o.faults.off[1].camera, 2u);
  EXPECT_EQ(o.faults.off[1].tick, 200u);
  EXPECT_EQ(o.faults.off[1].ticks, 10u);
  EXPECT_EQ(o.faults.missing_rate, 0.1);
  EXPECT_EQ(o.faults.blinks_per_frame, 0.5);
}

TEST(SimArguments, RefusalsSayWhatToGive) {
  EXPECT_EQ(refusal_of({"--bump", "2:450", "sim"}),
            "--bump 2:450: must be CAMERA:TICK:DEGREES, like 2:450:0.5");
  for (const char* text :
       {"0:1:2", "x:1:2", "1:-1:2", "1:2:3:4", "1:2:", ":::", "", "1:2:3 ", "99999999999:1:1"}) {
    EXPECT_THAT(refusal_of({"--off", text, "sim"}), HasSubstr("must be CAMERA:TICK:TICKS")) << text;
  }
  EXPECT_THAT(refusal_of({"--off", "5:1:1", "sim"}), HasSubstr("faults.off.camera"));
  EXPECT_THAT(refusal_of({"--slip", "1:2:0.5", "sim"}),
              HasSubstr("--slip 1:2:0.5: must be CAMERA:TICK:PULSES"));
  EXPECT_THAT(refusal_of({"--person", "sim"}), HasSubstr("--wave"));
  EXPECT_THAT(refusal_of({"--bodies", "2", "sim"}), HasSubstr("--motion tumbling"));
  EXPECT_THAT(refusal_of({"--wave", "0,1", "--motion", "pairs", "sim"}), HasSubstr("leave out --motion"));
  EXPECT_THAT(refusal_of({"--motion", "pairs", "--markers", "3", "sim"}), HasSubstr("even"));
  EXPECT_THAT(refusal_of({"--motion", "crossing", "--bodies", "3", "sim"}), HasSubstr("two bodies cross"));
  EXPECT_THAT(refusal_of({"--calibration-error", "-1", "sim"}), HasSubstr("0 to 50 pixels"));
  EXPECT_THROW(parsed({"--motion", "dancing", "sim"}), CLI::ValidationError);
}

TEST(SimArguments, TheCalibrationToldIsWrongByTheErrorAskedFor) {
  const Calibration exact = sim_calibration({});
  const Calibration plain = told_calibration(parsed({"sim"}), exact);
  EXPECT_EQ(plain.cameras[0].world_from_camera.translation, exact.cameras[0].world_from_camera.translation);
  const Calibration wrong = told_calibration(parsed({"--calibration-error", "0.3", "sim"}), exact);
  EXPECT_NE(wrong.cameras[0].world_from_camera.translation, exact.cameras[0].world_from_camera.translation);
  EXPECT_EQ(wrong.cameras[0].rms_px, 0.3);
}

}  // namespace
}  // namespace glint::apps
