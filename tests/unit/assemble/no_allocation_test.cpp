// SPDX-License-Identifier: MIT
// Nothing is allocated once an assembler exists, start-up and faults included.
#include <gtest/gtest.h>

#include "tests/support/allocations.hpp"
#include "tests/unit/assemble/simulated_rig.hpp"

namespace glint::testing {
namespace {

TEST(NoAllocation, FromTheFirstFrameOn) {
  RigOptions options;
  options.pulses = 3000;
  options.jitter_s = 1.5e-3;
  options.faults = {.never_sent = 0.02, .lost_by_host = 0.02, .twice = 0.02, .late = 0.02, .corrupt = 0.02};
  options.away = {{1, 500, 900}};
  const SimulatedRig rig(options);
  RigRun run(rig, AssembleOptions{});
  const std::size_t before = allocations();
  run.run();
  for (std::uint64_t pulse = 0; pulse < 100; ++pulse) {
    run.assembler().add_pulse(TriggerNo{pulse}, at(2000.0 + static_cast<double>(pulse) / 90.0),
                              pulse % 3 != 0);
  }
  EXPECT_EQ(allocations(), before);
  EXPECT_GT(run.sets, 2900u);
  EXPECT_EQ(run.mispaired, 0u);
}

}  // namespace
}  // namespace glint::testing
