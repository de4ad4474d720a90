// SPDX-License-Identifier: MIT
// The wire: the same for C and C++, and the code the same for the board and everybody else.
#include <gtest/gtest.h>

#include <cstddef>

#include "firmware/protocol/pulse_code.h"
#include "firmware/protocol/sync_report.h"
#include "host/base/pulse_code.hpp"

// Seen by a C compiler, in protocol_c_test.c.
extern "C" const std::size_t glint_offsets_in_c[];

namespace glint {
namespace {

TEST(Protocol, IsLaidOutTheSameInCAndCpp) {
  const std::size_t offsets[] = {offsetof(glint_sync_input, report_no),
                                 offsetof(glint_sync_input, tick),
                                 offsetof(glint_sync_input, step_ticks),
                                 offsetof(glint_sync_input, trigger_flags),
                                 offsetof(glint_sync_status, now_tick),
                                 offsetof(glint_sync_status, refusal_limit),
                                 offsetof(glint_sync_run, code_seed),
                                 offsetof(glint_sync_output, width_ticks),
                                 offsetof(glint_sync_limits, min_period_ticks),
                                 offsetof(glint_sync_info, build),
                                 offsetof(glint_sync_time, tick),
                                 offsetof(glint_sync_selftest, most_period_ticks)};
  for (std::size_t i = 0; i < std::size(offsets); ++i) EXPECT_EQ(offsets[i], glint_offsets_in_c[i]) << i;
  EXPECT_EQ(glint_offsets_in_c[std::size(offsets)], ~std::size_t{0});
}

TEST(Protocol, TheBoardsCodeIsTheHosts) {
  for (const std::uint32_t seed : {0u, 1u, 4711u, 0xffffffffu})
    for (const std::uint32_t group : {18u, 30u, 31u, 82u, 1024u}) {
      const PulseCode code(seed, group);
      for (std::uint32_t n = 0; n < 600; ++n)
        ASSERT_EQ(std::uint64_t{n % 256} * group + glint_pulse_code_dark(seed, group, n),
                  code.dark_pulse(n % 256));
    }
}

}  // namespace
}  // namespace glint
