// SPDX-License-Identifier: MIT
// Random numbers: the same everywhere, and of the right distribution.
#include "host/sim/random.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace glint::sim {
namespace {

TEST(Random, FirstNumbersNeverChange) {
  // Recordings that were made from a seed must come out the same in later versions.
  Random random(1);
  EXPECT_EQ(random.bits(), 4665668604702890953u);
  EXPECT_EQ(mix(0), 16294208416658607535u);  // SplitMix64's first output for seed 0
}

TEST(NormalTable, MeanZeroVarianceOne) {
  const NormalTable normal;
  double sum = 0.0, squares = 0.0, fourth = 0.0;
  for (std::uint64_t i = 0; i < 4096; ++i) {
    const double x = static_cast<double>(normal[i]);
    sum += x;
    squares += x * x;
    fourth += x * x * x * x;
  }
  EXPECT_EQ(sum, 0.0);
  EXPECT_NEAR(squares / 4096, 1.0, 1e-4);
  EXPECT_NEAR(fourth / 4096, 3.0, 0.05);  // normal: 3
}

TEST(NormalTable, QuantilesAreNormal) {
  const NormalTable normal;
  // 84.13 % lie below one standard deviation.
  const double at = static_cast<double>(normal[static_cast<std::uint64_t>(0.841345 * 4096)]);
  EXPECT_NEAR(at, 1.0, 2e-3);
}

}  // namespace
}  // namespace glint::sim
