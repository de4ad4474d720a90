// SPDX-License-Identifier: MIT
// Cameras that expose at other moments than the rest are found out by what moves, and no others are.
#include "host/calibrate/sample_timing.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "host/geometry/sphere_bias.hpp"
#include "host/sim/random.hpp"
#include "host/sim/wand_dance.hpp"
#include "tests/unit/calibrate/waved_target.hpp"

namespace glint::test {
namespace {

using ::testing::HasSubstr;

constexpr double kRate_hz = 60.0;
constexpr std::size_t kTicks = 900;

/// How much later than the tick a camera exposes.
using Lateness = std::function<double(std::uint32_t camera, sim::Random& random)>;

/// What four cameras see of a wand that is waved, each at its own moment, with 0.05 px of noise.
SampleSet waved(const Calibration& rig, std::uint64_t seed, const Lateness& lateness_s,
                double rate_hz = kRate_hz, bool still = false) {
  SampleSet samples;
  samples.target = wand_target({0.0, 0.13, 0.39}, 0.0063);
  samples.cameras = sample_cameras(rig);
  samples.rate_hz = rate_hz;
  SimOptions options;
  options.seed = seed;
  options.wand_m = {0.0, 0.13, 0.39};
  const sim::WandDance dance(options, sim::Volume{});
  const std::vector<Camera> cameras(rig.cameras.begin(), rig.cameras.end());
  sim::Random random(seed);
  const sim::NormalTable normal;
  for (std::uint64_t tick = 0; tick < kTicks; ++tick) {
    for (std::uint32_t c = 0; c < cameras.size(); ++c) {
      const double time_s = still ? 1.0 : static_cast<double>(tick) / kRate_hz + lateness_s(c, random);
      for (std::uint32_t point = 0; point < 3; ++point) {
        Eigen::Vector3d in_camera = cameras[c].in_camera(dance.marker(point, time_s).position_in_world);
        in_camera.head<2>() *= sphere_bias_factor(options.marker_radius_m, in_camera.z());
        const auto pixel = cameras[c].project(rig.cameras[c].world_from_camera * in_camera);
        const Eigen::Vector2d error(static_cast<double>(normal.draw(random)),
                                    static_cast<double>(normal.draw(random)));
        if (pixel && cameras[c].inside(*pixel))
          samples.sightings.push_back({tick, c, point, *pixel + 0.05 * error});
      }
    }
  }
  return samples;
}

double on_time(std::uint32_t, sim::Random&) { return 0.0; }

/// The only camera that is late, by `delay_s`, is found and named as such.
void expect_found(double delay_s, const std::string& says) {
  const Calibration rig = sim_calibration({});
  for (std::uint32_t late = 0; late < 4; ++late) {
    const auto timing = timing_of(
        rig, waved(rig, 1 + late, [&](std::uint32_t c, sim::Random&) { return c == late ? delay_s : 0.0; }));
    ASSERT_TRUE(timing);
    ASSERT_EQ(timing->cameras.size(), 4u);
    // They are told against the mean of all four, which is late itself by a quarter.
    for (std::uint32_t c = 0; c < 4; ++c) {
      EXPECT_NEAR(timing->cameras[c].delay_s, (c == late ? 0.75 : -0.25) * delay_s, 0.0005);
      EXPECT_LT(timing->cameras[c].delay_sd_s, 0.0005);
    }
    const std::vector<std::string> said = timing_sentences(*timing, rig);
    ASSERT_EQ(said.size(), 1u) << ::testing::PrintToString(said);
    EXPECT_THAT(said[0], HasSubstr(rig.cameras[late].name));
    EXPECT_THAT(said[0], HasSubstr(says));
  }
}

TEST(SampleTiming, FindsACameraThatIsLate) { expect_found(0.008, "8.0 ms later"); }

TEST(SampleTiming, FindsACameraThatIsEarly) { expect_found(-0.003, "3.0 ms earlier"); }

TEST(SampleTiming, AccusesNoneThatIsOnTime) {
  const Calibration rig = sim_calibration({});
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const auto timing = timing_of(rig, waved(rig, seed, on_time));
    ASSERT_TRUE(timing);
    EXPECT_GT(timing->sightings, 1000u);
    for (const CameraTiming& camera : timing->cameras) EXPECT_LT(std::abs(camera.delay_s), 0.0002);
    EXPECT_THAT(timing_sentences(*timing, rig), ::testing::IsEmpty());
  }
}

TEST(SampleTiming, TellsCamerasThatAreNotSynchronised) {
  const Calibration rig = sim_calibration({});
  const sim::NormalTable normal;
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const auto timing = timing_of(rig, waved(rig, seed, [&](std::uint32_t, sim::Random& random) {
                                    return 0.005 * static_cast<double>(normal.draw(random));
                                  }));
    ASSERT_TRUE(timing);
    EXPECT_NEAR(timing->jitter_s, 0.005, 0.002);
    const std::vector<std::string> said = timing_sentences(*timing, rig);
    ASSERT_FALSE(said.empty());
    EXPECT_THAT(said[0], HasSubstr("not synchronised"));
  }
}

TEST(SampleTiming, SaysNothingWhereNothingCanBeKnown) {
  const Calibration rig = sim_calibration({});
  EXPECT_FALSE(timing_of(rig, waved(rig, 1, on_time, kRate_hz, true))) << "it stood still";
  EXPECT_FALSE(timing_of(rig, waved(rig, 1, on_time, 0.0))) << "the rate is unknown";
  SampleSet few = waved(rig, 1, on_time);
  std::erase_if(few.sightings, [](const Sighting& s) { return s.tick >= 10; });
  EXPECT_FALSE(timing_of(rig, few));
  SampleSet gaps = waved(rig, 1, on_time);
  std::erase_if(gaps.sightings, [](const Sighting& s) { return s.tick % 2 == 1; });
  EXPECT_FALSE(timing_of(rig, gaps)) << "no tick has neighbours";
}

}  // namespace
}  // namespace glint::test
