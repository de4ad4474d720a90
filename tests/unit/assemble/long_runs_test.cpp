// SPDX-License-Identifier: MIT
// A hundred thousand pulses and more with every fault: nothing is mispaired, and the ledger is what was
// injected.
#include <gtest/gtest.h>

#include <algorithm>
#include <iostream>
#include <string>

#include "tests/unit/assemble/simulated_rig.hpp"

namespace glint::testing {
namespace {

struct Case {
  const char* name;
  RigOptions rig;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

constexpr RigFaults kAllFaults{
    .never_sent = 0.02, .lost_by_host = 0.01, .twice = 0.01, .late = 0.01, .corrupt = 0.005};

std::vector<RigOptions::Away> comings_and_goings(std::int64_t pulses) {
  std::vector<RigOptions::Away> away;
  for (std::int64_t k = 1; k < 10; ++k) {
    const std::int64_t from = k * pulses / 10;
    away.push_back({static_cast<std::size_t>(k) % 4, from, from + 7 + 113 * k * k});
  }
  return away;
}

RigOptions rig(double rate_hz, double jitter_s, double quantum_s, double ppm, std::uint64_t seed) {
  RigOptions options;
  options.rate_hz = rate_hz;
  options.jitter_s = jitter_s;
  options.quantum_s = quantum_s;
  options.crystal_ppm = ppm;
  options.offset_s = {0.0, 0.0004, -0.0003, 0.0007};
  options.pulses = 100'000;
  options.faults = kAllFaults;
  options.away = comings_and_goings(options.pulses);
  options.seed = seed;
  return options;
}

RigOptions with(RigOptions options, double origin_s, double latency_s, std::uint32_t first_sequence) {
  options.origin_s = origin_s;
  options.latency_s = latency_s;
  options.first_sequence = first_sequence;
  return options;
}

/// Every frame that was delivered is counted once.
void expect_all_frames_counted(const SimulatedRig& rig, const Ledger& ledger) {
  for (std::size_t camera = 0; camera < ledger.cameras.size(); ++camera) {
    const auto delivered = std::count_if(
        rig.deliveries.begin(), rig.deliveries.end(),
        [camera](const Delivery& delivery) { return delivery.camera == camera && !delivery.left; });
    const CameraLedger& got = ledger.cameras[camera];
    const std::uint64_t lost = got[FrameFate::LostByHost] + got[FrameFate::LostByCamera];
    EXPECT_EQ(got.total() - lost + got.duplicates + got.unplaced + got.warm_up,
              static_cast<std::uint64_t>(delivered))
        << "camera " << camera;
  }
}

class LongRun : public ::testing::TestWithParam<Case> {};

TEST_P(LongRun, LedgerIsWhatWasInjected) {
  const SimulatedRig simulated(GetParam().rig);
  RigRun run(simulated, {.rate_hz = simulated.options.rate_hz});
  run.run();
  EXPECT_EQ(run.mispaired, 0u);
  EXPECT_EQ(run.unbalanced, 0u);
  EXPECT_EQ(run.not_in_order, 0u);
  EXPECT_EQ(run.damaged, 0u);
  EXPECT_EQ(run.second_frames, 0u);
  EXPECT_EQ(run.not_aligned, 0u);
  EXPECT_EQ(run.outside_error, 0u);
  ASSERT_TRUE(run.first);
  EXPECT_LT(*run.first, 60);
  const Ledger& ledger = run.assembler().ledger();
  expect_all_frames_counted(simulated, ledger);
  EXPECT_EQ(static_cast<std::int64_t>(ledger.pulses), simulated.options.pulses - *run.first);
  for (std::size_t camera = 0; camera < 4; ++camera) {
    const CameraLedger expected = run.expected(camera);
    const CameraLedger& got = ledger.cameras[camera];
    using enum FrameFate;
    for (const FrameFate fate : {Skipped, LostByHost, LostByCamera, Corrupt, Dark}) {
      EXPECT_EQ(got[fate], expected[fate]) << "camera " << camera << " fate " << static_cast<int>(fate);
    }
    // Nobody waits for the first frame of a camera that was away; then it may be late.
    const auto returns = static_cast<std::uint64_t>(
        std::count_if(simulated.options.away.begin(), simulated.options.away.end(),
                      [camera](const RigOptions::Away& away) { return away.camera == camera; }));
    EXPECT_GE(got[Late], expected[Late]) << "camera " << camera;
    EXPECT_LE(got[Late], expected[Late] + returns) << "camera " << camera;
    EXPECT_EQ(got[Used] + got[Late], expected[Used] + expected[Late]) << "camera " << camera;
    EXPECT_EQ(got.duplicates, expected.duplicates) << "camera " << camera;
    EXPECT_EQ(got.unplaced, 0u) << "camera " << camera;
  }
  std::cout << "[ measured ] " << run.frames << " frames in " << run.sets
            << " sets, 0 mispaired; exposed within " << run.most_time_error_s * 1e6 << " us, said "
            << run.assembler().exposed_error_s() * 1e6 << " us\n";
}

INSTANTIATE_TEST_SUITE_P(
    Assembler, LongRun,
    ::testing::Values(Case{"exact_90_hz", rig(90, 0.0, 0.0, 100, 1)},
                      Case{"jitter_0_3_ms_90_hz", rig(90, 0.3e-3, 0.0, -100, 2)},
                      Case{"jitter_0_7_ms_90_hz", rig(90, 0.7e-3, 0.0, 50, 3)},
                      Case{"quantum_4_ms_90_hz", rig(90, 0.0, 4e-3, 100, 4)},
                      Case{"jitter_0_1_ms_250_hz", rig(250, 0.1e-3, 0.0, 100, 7)},
                      Case{"jitter_0_3_ms_250_hz", rig(250, 0.3e-3, 0.0, -100, 8)},
                      Case{"stamps_in_the_future", with(rig(90, 0.2e-3, 0.0, 20, 9), 5e6, -0.029, 0)},
                      Case{"sequence_wraps", with(rig(90, 0.2e-3, 0.0, 20, 10), 0.5, 0.004, 4'294'950'000u)}),
    [](const auto& given) { return std::string(given.param.name); });

struct RoughCase {
  const char* name;
  RigOptions rig;
  double most_unplaced;  ///< share of the frames
};

void PrintTo(const RoughCase& c, std::ostream* out) { *out << c.name; }

// Beyond what stamps can tell for every frame: some are refused, none is wrong.
class RoughRun : public ::testing::TestWithParam<RoughCase> {};

TEST_P(RoughRun, RefusesRatherThanMispairs) {
  const SimulatedRig simulated(GetParam().rig);
  RigRun run(simulated, {.rate_hz = simulated.options.rate_hz});
  run.run();
  EXPECT_EQ(run.mispaired, 0u);
  EXPECT_EQ(run.unbalanced, 0u);
  EXPECT_EQ(run.not_in_order, 0u);
  expect_all_frames_counted(simulated, run.assembler().ledger());
  std::uint64_t unplaced = 0;
  for (const CameraLedger& camera : run.assembler().ledger().cameras) unplaced += camera.unplaced;
  EXPECT_LT(static_cast<double>(unplaced),
            GetParam().most_unplaced * static_cast<double>(simulated.deliveries.size()));
  std::cout << "[ measured ] " << run.frames << " frames used, " << run.mispaired << " mispaired, "
            << unplaced << " unplaced\n";
}

INSTANTIATE_TEST_SUITE_P(
    Assembler, RoughRun,
    ::testing::Values(RoughCase{"jitter_1_ms_90_hz", rig(90, 1.0e-3, 0.0, 50, 15), 1e-4},
                      RoughCase{"jitter_1_5_ms_90_hz", rig(90, 1.5e-3, 0.0, 100, 11), 0.03},
                      RoughCase{"jitter_2_ms_90_hz", rig(90, 2.0e-3, 0.0, -100, 12), 0.4},
                      RoughCase{"jitter_0_6_ms_250_hz", rig(250, 0.6e-3, 0.0, 50, 14), 0.1},
                      RoughCase{"quantum_4_ms_and_jitter_0_2_ms_90_hz", rig(90, 0.2e-3, 4e-3, -100, 5), 1e-4},
                      RoughCase{"quantum_4_ms_and_jitter_1_ms_90_hz", rig(90, 1.0e-3, 4e-3, 50, 13), 0.03},
                      RoughCase{"quantum_4_ms_100_hz", rig(100, 0.1e-3, 4e-3, 50, 6), 1e-3},
                      RoughCase{"quantum_4_ms_120_hz", rig(120, 0.2e-3, 4e-3, -50, 16), 3e-3}),
    [](const auto& given) { return std::string(given.param.name); });

}  // namespace
}  // namespace glint::testing
