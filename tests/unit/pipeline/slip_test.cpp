// SPDX-License-Identifier: MIT
// A camera that slips by whole pulses mid-run: found, corrected, and no point is called good in between.
// GLINT_SLIP_TABLE=RUNS prints the table of docs/live-capture.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "host/sim/random.hpp"
#include "tests/unit/pipeline/coded_rig.hpp"

namespace glint::testing {
namespace {

constexpr std::uint32_t kCameras = 4;

struct SlipRun {
  bool phase_found = false;
  std::optional<double> found_s, in_step_s, proven_s;  ///< since the first wrong frame
  std::uint64_t false_alarms = 0;                      ///< slips found that were none, phases lost
  std::uint64_t points = 0, good = 0;                  ///< all points, and those whose cameras were proven
  std::uint64_t wrong = 0;                             ///< points of cameras that showed different exposures
  std::uint64_t wrong_and_good = 0;
  std::uint64_t pulses = 0, dark = 0, lost_in_the_dark = 0;
  bool balanced = false;
};

CodedRigOptions options_of(std::uint64_t seed, std::int64_t pulses) {
  CodedRigOptions options;
  options.scene.cameras = kCameras;
  options.scene.markers = 20;
  options.scene.max_speed_m_s = 2.0;
  options.scene.seed = seed;
  options.scene.code_seed = static_cast<std::uint32_t>(1000 + seed);
  options.scene.code_first = static_cast<std::uint32_t>(seed * 7919);
  options.rig.pulses = pulses;
  options.rig.jitter_s = 0.2e-3;
  options.rig.crystal_ppm = 30.0;
  options.rig.seed = seed;
  options.rig.faults.never_sent = 0.01;
  options.rig.faults.lost_by_host = 0.01;
  return options;
}

/// Exposure that the cameras show which do not slip; -1 if none of them had a frame.
std::int64_t reference(const ShownExposures& shown, std::size_t slipping) {
  for (std::size_t c = 0; c < kCameras; ++c) {
    if (c != slipping && shown[c] >= 0) return shown[c];
  }
  return -1;
}

SlipRun run(const CodedRigOptions& options) {
  const Scene scene(options.scene);
  auto input = std::make_unique<CodedRig>(options, scene);
  const CodedRig& rig = *input;
  MatchOptions match;
  match.marker_radius_m = options.scene.marker_radius_m;
  // So wide that slow markers are still matched when a camera has slipped: that is when points are wrong.
  match.gate_px = 10.0;
  match.sigma_px = 2.0;
  TrackPipeline pipeline(std::move(input), scene.calibration(), match, {});
  const std::size_t slipping = options.rig.slip ? options.rig.slip->camera : kCameras;
  const std::int64_t from = options.rig.slip ? options.rig.slip->from : options.rig.pulses;
  SlipRun result;
  std::optional<Timestamp> slipped_at;
  std::uint64_t before_dark = 0;
  bool was_dark = false;
  pipeline.run([&](const TickResult& tick) {
    const ShownExposures& shown = rig.shown(tick.trigger);
    const std::int64_t true_exposure = reference(shown, slipping);
    const bool slipping_is_in = slipping < kCameras && shown[slipping] >= 0 && true_exposure >= 0;
    if (slipping_is_in && true_exposure >= from && !slipped_at && shown[slipping] != true_exposure)
      slipped_at = tick.exposed;
    const auto since_s = [&] { return slipped_at ? seconds_between(*slipped_at, tick.exposed) : -1.0; };
    if (slipping_is_in && result.found_s && !result.in_step_s && shown[slipping] == true_exposure)
      result.in_step_s = since_s();
    for (const AlignmentEvent& event : tick.events) {
      switch (event.kind) {
        case AlignmentEvent::Kind::PhaseFound:
          result.phase_found = true;
          break;
        case AlignmentEvent::Kind::SlipFound:
          if (slipped_at && !result.found_s && index(event.camera) == slipping &&
              event.pulses == options.rig.slip->pulses) {
            result.found_s = since_s();
          } else {
            ++result.false_alarms;
          }
          break;
        case AlignmentEvent::Kind::SlipCorrected:
          if (result.in_step_s) result.proven_s = since_s();
          break;
        case AlignmentEvent::Kind::NoPhase:
        case AlignmentEvent::Kind::PhaseLost:
          ++result.false_alarms;
          break;
      }
    }
    for (const TrackedPoint& point : tick.points) {
      bool wrong = false;
      for (std::size_t c = 0; c < kCameras; ++c) {
        if ((point.cameras >> c & 1U) != 0) wrong = wrong || shown[c] != true_exposure;
      }
      const bool good = tick.aligned(point).value_or(true);
      ++result.points;
      result.good += good ? 1 : 0;
      result.wrong += wrong ? 1 : 0;
      result.wrong_and_good += good && wrong ? 1 : 0;
    }
    if (was_dark && tick.points.size() + 3 < before_dark) ++result.lost_in_the_dark;
    if (!tick.dark && !was_dark) before_dark = tick.points.size();
    was_dark = tick.dark;
    result.dark += tick.dark ? 1 : 0;
    ++result.pulses;
  });
  result.balanced = rig.ledger()->balanced();
  return result;
}

CodedRigOptions slip_options(std::uint64_t seed, int slip, double rate_hz = 90.0) {
  const auto twelve_seconds = static_cast<std::int64_t>(12.0 * rate_hz);
  CodedRigOptions options = options_of(seed, twelve_seconds);
  options.scene.rate_hz = rate_hz;
  // Anywhere between two dark pulses, after everything has been proven.
  const auto from =
      twelve_seconds / 2 +
      static_cast<std::int64_t>(sim::mix(seed * 64 + static_cast<std::uint64_t>(slip + 8)) % 130);
  options.rig.slip =
      RigOptions::Slip{seed % kCameras, from, slip, slip > 0 ? 1 + static_cast<int>(seed) % slip : 0};
  return options;
}

class ASlip : public ::testing::TestWithParam<int> {};

TEST_P(ASlip, IsFoundAndCorrectedAndNoWrongPointIsCalledGood) {
  const SlipRun r = run(slip_options(3, GetParam()));
  EXPECT_TRUE(r.phase_found);
  ASSERT_TRUE(r.found_s);
  EXPECT_LT(*r.found_s, 1.0);
  ASSERT_TRUE(r.in_step_s);
  EXPECT_TRUE(r.proven_s);
  EXPECT_EQ(r.false_alarms, 0u);
  EXPECT_GT(r.wrong, 0u) << "the slip did no harm: the test shows nothing";
  EXPECT_EQ(r.wrong_and_good, 0u);
  EXPECT_GT(r.good, r.points / 4);
  EXPECT_GT(r.dark, 10u);
  EXPECT_EQ(r.lost_in_the_dark, 0u);
  EXPECT_TRUE(r.balanced);
}

INSTANTIATE_TEST_SUITE_P(Pulses, ASlip, ::testing::Values(1, 2, 3, -1, -2, -3, 8, -8),
                         [](const auto& tested) {
                           return (tested.param < 0 ? "Ahead" : "Behind") +
                                  std::to_string(std::abs(tested.param));
                         });

TEST(NoSlip, IsFoundWhereThereIsNone) {
  const SlipRun r = run(options_of(5, 3000));
  EXPECT_TRUE(r.phase_found);
  EXPECT_EQ(r.false_alarms, 0u);
  EXPECT_EQ(r.wrong, 0u);
  EXPECT_GT(r.good, r.points / 4);
}

TEST(NoSlip, IsFoundWhereACamerasMarkersAreHiddenNowAndThen) {
  CodedRigOptions options = options_of(6, 2000);
  for (std::int64_t from = 20; from < 2000; from += 25 + from % 31) {
    options.blackouts.push_back({static_cast<std::uint32_t>(from % 3), from, from + 1 + from % 14});
  }
  const SlipRun r = run(options);
  EXPECT_TRUE(r.phase_found);
  EXPECT_EQ(r.false_alarms, 0u);
  EXPECT_EQ(r.wrong, 0u);
  EXPECT_GT(r.good, r.points / 5);
}

struct Line {
  std::uint64_t runs = 0, found = 0, in_time = 0, proven = 0, alarms = 0, wrong = 0, wrong_and_good = 0;
  std::uint64_t pulses = 0, points = 0, good = 0;
  std::vector<double> found_s, proven_s;

  void add(const SlipRun& r) {
    ++runs;
    found += r.found_s ? 1U : 0U;
    in_time += r.found_s && *r.found_s < 1.0 ? 1U : 0U;
    proven += r.proven_s ? 1U : 0U;
    if (r.found_s) found_s.push_back(*r.found_s);
    if (r.proven_s) proven_s.push_back(*r.proven_s);
    alarms += r.false_alarms;
    wrong += r.wrong;
    wrong_and_good += r.wrong_and_good;
    pulses += r.pulses;
    points += r.points;
    good += r.good;
  }
  void print(const std::string& name) {
    const auto quantile = [](std::vector<double>& values, double q) {
      if (values.empty()) return 0.0;
      std::sort(values.begin(), values.end());
      return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1))];
    };
    std::printf(
        "%-8s runs %3llu  pulses %7llu  found %3llu (within 1 s %3llu)  median %.2f max %.2f s  proven again "
        "%3llu median %.2f max %.2f s  false alarms %llu  points %llu good %.1f %%  wrong %llu  wrong and "
        "good "
        "%llu\n",
        name.c_str(), static_cast<unsigned long long>(runs), static_cast<unsigned long long>(pulses),
        static_cast<unsigned long long>(found), static_cast<unsigned long long>(in_time),
        quantile(found_s, 0.5), quantile(found_s, 1.0), static_cast<unsigned long long>(proven),
        quantile(proven_s, 0.5), quantile(proven_s, 1.0), static_cast<unsigned long long>(alarms),
        static_cast<unsigned long long>(points),
        100.0 * static_cast<double>(good) / static_cast<double>(points),
        static_cast<unsigned long long>(wrong), static_cast<unsigned long long>(wrong_and_good));
    std::fflush(stdout);
  }
};

TEST(SlipTable, Print) {
  const char* const wanted = std::getenv("GLINT_SLIP_TABLE");
  if (wanted == nullptr) GTEST_SKIP() << "GLINT_SLIP_TABLE=20 prints it";
  const std::uint64_t runs = std::strtoull(wanted, nullptr, 10);
  for (const int slip : {1, 2, 3, -1, -2, -3}) {
    Line line;
    for (std::uint64_t seed = 100; seed < 100 + runs; ++seed) line.add(run(slip_options(seed, slip)));
    line.print("slip " + std::to_string(slip));
    EXPECT_EQ(line.wrong_and_good, 0u);
    EXPECT_EQ(line.alarms, 0u);
  }
  Line fast;
  for (std::uint64_t seed = 300; seed < 300 + runs; ++seed) fast.add(run(slip_options(seed, 2, 250.0)));
  fast.print("slip 2 at 250 Hz");
  EXPECT_EQ(fast.wrong_and_good, 0u);
  EXPECT_EQ(fast.alarms, 0u);
  Line none;
  for (std::uint64_t seed = 500; seed < 500 + runs; ++seed) none.add(run(options_of(seed, 5500)));
  none.print("none");
  EXPECT_EQ(none.alarms, 0u);
  Line told;
  for (std::uint64_t seed = 700; seed < 700 + runs; ++seed) {
    CodedRigOptions options = options_of(seed, 1080);
    options.rig.faults.never_sent = 0.0;
    options.rig.faults.lost_by_host = 0.02;
    told.add(run(options));
  }
  told.print("none, all losses counted by the driver");
  EXPECT_EQ(told.alarms, 0u);
}

}  // namespace
}  // namespace glint::testing
