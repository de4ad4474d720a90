// SPDX-License-Identifier: MIT
// Which pulses are dark, as the sync board must know it too.
#include "host/base/pulse_code.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <vector>

namespace glint {
namespace {

TEST(PulseCode, HasOneDarkPulseInTheFirstHalfOfEachGroup) {
  for (const std::uint32_t group : {18U, 19U, 30U, 116U, 1024U}) {
    const PulseCode code(7, group);
    for (std::uint64_t n = 0; n < 600; ++n) {
      unsigned dark = 0;
      for (std::uint64_t k = 0; k < group; ++k) {
        if (!code.dark(n * group + k)) continue;
        ++dark;
        EXPECT_LT(k, group / 2);
        EXPECT_EQ(code.dark_pulse(static_cast<std::uint32_t>(n % PulseCode::kGroups)),
                  (n * group + k) % code.length());
      }
      EXPECT_EQ(dark, 1u);
    }
  }
}

TEST(PulseCode, NeverLeavesALongGapNorAShortOne) {
  const PulseCode code(99, 30);
  std::uint64_t last = 0, least = 1000, most = 0;
  for (std::uint64_t pulse = 0; pulse < 3 * code.length(); ++pulse) {
    if (!code.dark(pulse)) continue;
    if (last != 0) {
      least = std::min(least, pulse - last);
      most = std::max(most, pulse - last);
    }
    last = pulse;
  }
  EXPECT_GE(least, 16u);
  EXPECT_LE(most, 44u);
}

// The board's firmware is written after the comment in the header; so is this.
TEST(PulseCode, FollowsItsDescription) {
  for (const std::uint32_t seed : {0U, 1U, 4'294'967'295U}) {
    const std::uint32_t group = 42;
    const PulseCode code(seed, group);
    for (std::uint32_t pulse = 0; pulse < 300 * group; ++pulse) {
      const std::uint32_t n = pulse / group % 256;
      std::uint32_t x = seed + 0x9e3779b9u * (n + 1);
      x = (x ^ (x >> 16)) * 0x85ebca6bu;
      x = (x ^ (x >> 13)) * 0xc2b2ae35u;
      x = x ^ (x >> 16);
      const auto offset = static_cast<std::uint32_t>((static_cast<std::uint64_t>(x) * (group / 2)) >> 32);
      ASSERT_EQ(code.dark(pulse), pulse % group == offset) << seed << " " << pulse;
    }
  }
}

// Figures that boards in the field rely on: they must never change.
TEST(PulseCode, IsThisOne) {
  const PulseCode code(20'260, 42);
  std::vector<std::uint64_t> dark;
  for (std::uint64_t pulse = 0; pulse < 336; ++pulse) {
    if (code.dark(pulse)) dark.push_back(pulse);
  }
  EXPECT_EQ(dark, (std::vector<std::uint64_t>{8, 54, 93, 141, 175, 223, 254, 311}));
}

TEST(PulseCode, ShiftedIsAnotherCode) {
  const PulseCode code(5, 30);
  for (std::uint64_t shift = 1; shift < code.length(); ++shift) {
    unsigned same = 0;
    for (std::uint32_t n = 0; n < PulseCode::kGroups; ++n)
      same += code.dark(code.dark_pulse(n) + shift) ? 1U : 0U;
    ASSERT_LT(same, 64u) << shift;
  }
}

TEST(PulseCode, TheRecommendedGroupKeepsDarkPulsesWithinHalfASecond) {
  EXPECT_EQ(PulseCode::recommended_group(90.0), 30u);
  EXPECT_EQ(PulseCode::recommended_group(120.0), 40u);
  EXPECT_EQ(PulseCode::recommended_group(250.0), 82u);
  for (const double rate_hz : {54.0, 90.0, 119.88, 250.0, 1000.0}) {
    const std::uint32_t group = PulseCode::recommended_group(rate_hz);
    EXPECT_LT((group + group / 2 - 1) / rate_hz, 0.5) << rate_hz;
  }
  EXPECT_EQ(PulseCode::recommended_group(1.0), PulseCode::kLeastGroup);
  EXPECT_EQ(PulseCode::recommended_group(1e9), PulseCode::kMostGroup);
}

}  // namespace
}  // namespace glint
