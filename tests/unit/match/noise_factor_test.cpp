// SPDX-License-Identifier: MIT
#include "host/match/noise_factor.hpp"

#include <random>

#include <gtest/gtest.h>

namespace glint {
namespace {

// Views that decided half of the position: one degree of freedom of two is left.
void learn(NoiseFactor& factor, double true_factor, int residuals, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  for (int k = 0; k < residuals; ++k) {
    const double r = normal(random);
    factor.learn(true_factor * r * r, 1.0);
  }
}

TEST(NoiseFactor, IsOneUntilSomethingWasSeen) { EXPECT_EQ(NoiseFactor().value(), 1.0); }

TEST(NoiseFactor, FindsWhatResidualsShow) {
  for (const double true_factor : {0.5, 1.0, 1.6}) {
    NoiseFactor factor;
    learn(factor, true_factor, 20'000, 1);
    // Those above 8 times the mean are left out, which takes some percent off the variance.
    EXPECT_NEAR(factor.value(), true_factor, 0.08 * true_factor);
  }
}

TEST(NoiseFactor, FewResidualsHardlyCount) {
  NoiseFactor factor;
  learn(factor, 0.3, 5, 1);
  EXPECT_GT(factor.value(), 0.9);
}

TEST(NoiseFactor, WhatIsNoMarkersIsLeftOut) {
  NoiseFactor factor;
  learn(factor, 1.0, 2'000, 1);
  const double before = factor.value();
  for (int k = 0; k < 100; ++k) factor.learn(1000.0, 1.0);
  EXPECT_EQ(factor.value(), before);
}

TEST(NoiseFactor, AViewThatDecidedAllSaysNothing) {
  NoiseFactor factor;
  for (int k = 0; k < 1000; ++k) factor.learn(1e-9, 0.01);
  EXPECT_EQ(factor.value(), 1.0);
}

TEST(NoiseFactor, FollowsAChange) {
  NoiseFactor factor;
  learn(factor, 0.5, 20'000, 1);
  learn(factor, 1.5, 30'000, 2);
  EXPECT_GT(factor.value(), 1.35);
}

}  // namespace
}  // namespace glint
