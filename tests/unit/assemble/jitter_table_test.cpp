// SPDX-License-Identifier: MIT
// Where pairing breaks: GLINT_JITTER_TABLE=PULSES prints, for growing jitter, the share of frames that are
// refused and that are mispaired, beside what pairing by nearest time would mispair if it knew period and
// phase.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "tests/unit/assemble/simulated_rig.hpp"

namespace glint::testing {
namespace {

struct Row {
  std::uint64_t delivered = 0, mispaired = 0, unplaced = 0;
};

Row measure(double rate_hz, double jitter_s, double quantum_s, std::int64_t pulses, std::uint64_t seed) {
  RigOptions options;
  options.rate_hz = rate_hz;
  options.jitter_s = jitter_s;
  options.quantum_s = quantum_s;
  options.crystal_ppm = 50.0;
  options.offset_s = {0.0, 0.1e-3, -0.1e-3, 0.2e-3};
  options.pulses = pulses;
  options.faults = {.never_sent = 0.02, .lost_by_host = 0.01, .twice = 0.01, .late = 0.01, .corrupt = 0.005};
  options.seed = seed;
  const SimulatedRig rig(options);
  AssembleOptions assemble;
  assemble.rate_hz = rate_hz;
  RigRun run(rig, assemble);
  run.run();
  Row row;
  row.delivered = rig.deliveries.size();
  row.mispaired = run.mispaired;
  for (const CameraLedger& camera : run.assembler().ledger().cameras) {
    row.unplaced += camera.unplaced;
  }
  return row;
}

TEST(JitterTable, Print) {
  const char* const pulses = std::getenv("GLINT_JITTER_TABLE");
  if (pulses == nullptr) GTEST_SKIP() << "GLINT_JITTER_TABLE=100000 prints it";
  std::printf("rate_hz quantum_ms sigma_ms delivered refused mispaired nearest_time\n");
  for (const auto& [rate_hz, quantum_ms] : {std::pair{90.0, 0.0}, std::pair{250.0, 0.0}, std::pair{90.0, 4.0},
                                            std::pair{100.0, 4.0}, std::pair{120.0, 4.0}}) {
    for (const double sigma_ms : {0.0, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 1.0, 1.25, 1.5, 1.75, 2.0, 2.5}) {
      const double sigma_s = sigma_ms * 1e-3, period_s = 1.0 / rate_hz;
      if (sigma_s > 0.25 * period_s) continue;
      const Row row = measure(rate_hz, sigma_s, quantum_ms * 1e-3, std::atoll(pulses), 77);
      const auto delivered = static_cast<double>(row.delivered);
      const double nearest = sigma_s > 0.0 ? std::erfc(0.5 * period_s / sigma_s / std::numbers::sqrt2) : 0.0;
      std::printf("%5.0f %3.0f %5.2f %9.0f %8.1e %8.1e ", rate_hz, quantum_ms, sigma_ms, delivered,
                  static_cast<double>(row.unplaced) / delivered,
                  static_cast<double>(row.mispaired) / delivered);
      if (quantum_ms == 0.0) std::printf("%8.1e", nearest);
      std::printf("\n");
    }
  }
}

}  // namespace
}  // namespace glint::testing
