// SPDX-License-Identifier: MIT
#include "host/assemble/pulse_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace glint {
namespace {

constexpr double kPeriod = 1.0 / 90.0;

TEST(PulseGrid, FindsPeriodAndPhaseAndKnowsHowWell) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  int outside = 0;
  constexpr int kRuns = 200;
  for (int run = 0; run < kRuns; ++run) {
    const double period = kPeriod * (1.0 + 1e-4 * (run % 3 - 1));
    PulseGrid grid(kPeriod);
    grid.start(0, 5.0 + 0.2e-3 * normal(random), 0.04e-6);
    for (std::int64_t pulse = 0; pulse < 2000; ++pulse) {
      grid.observe(pulse, 5.0 + static_cast<double>(pulse) * period + 1e-3 * normal(random), 1e-6);
    }
    const double error = grid.time_s(2000) - (5.0 + 2000.0 * period);
    if (std::abs(error) > 3.0 * std::sqrt(grid.variance_s2(2000))) ++outside;
    EXPECT_LT(std::abs(error), 0.5e-3);
    EXPECT_NEAR(grid.period_s() / period, 1.0, 2e-4);
  }
  EXPECT_LE(outside, kRuns / 20);
}

TEST(PulseGrid, OneWildMeasurementDoesLittle) {
  PulseGrid grid(kPeriod);
  grid.start(0, 0.0, 1e-8);
  for (std::int64_t pulse = 0; pulse < 500; ++pulse) {
    grid.observe(pulse, static_cast<double>(pulse) * kPeriod, 1e-8);
  }
  grid.observe(500, 500.0 * kPeriod + 0.4 * kPeriod, 1e-8);
  EXPECT_NEAR(grid.time_s(501), 501.0 * kPeriod, 0.1e-3);
}

TEST(PulseGrid, MeasurementsMayComeOutOfOrder) {
  PulseGrid grid(kPeriod);
  grid.start(0, 0.0, 1e-8);
  for (std::int64_t pulse = 0; pulse < 1000; ++pulse) {
    const std::int64_t other = pulse % 2 == 0 ? pulse + 3 : pulse - 1;
    grid.observe(other, static_cast<double>(other) * kPeriod * 1.0001, 1e-8);
  }
  EXPECT_NEAR(grid.time_s(1000), 1000.0 * kPeriod * 1.0001, 20e-6);
}

TEST(PulseGrid, GrowsUncertainInSilence) {
  PulseGrid grid(kPeriod);
  grid.start(0, 0.0, 1e-8);
  for (std::int64_t pulse = 0; pulse < 1000; ++pulse) {
    grid.observe(pulse, static_cast<double>(pulse) * kPeriod, 1e-8);
  }
  EXPECT_LT(std::sqrt(grid.variance_s2(1000)), 1e-3 * kPeriod);
  EXPECT_GT(std::sqrt(grid.variance_s2(1000 + 90 * 600)), 0.1 * kPeriod);
}

TEST(PulseGrid, ReportedPulsesAreWhereTheBoardSays) {
  PulseGrid grid(kPeriod);
  EXPECT_FALSE(grid.add_reported(70, 1.0, true));  // the first follows nothing
  double time = 1.0;
  for (std::int64_t pulse = 71; pulse < 200; ++pulse) {
    time += kPeriod * (pulse % 2 == 0 ? 0.98 : 1.02);
    EXPECT_TRUE(grid.add_reported(pulse, time, pulse % 10 != 0));
    EXPECT_EQ(grid.time_s(pulse), time);
    EXPECT_EQ(grid.nearest(time + 0.4 * kPeriod), pulse);
    EXPECT_EQ(grid.dark(pulse), pulse % 10 == 0);
  }
  EXPECT_EQ(grid.variance_s2(199), 0.0);
  EXPECT_TRUE(grid.credible(207));
  EXPECT_FALSE(grid.credible(208));
  EXPECT_NEAR(grid.time_s(203), time + 4.0 * kPeriod, 0.02 * kPeriod);
}

TEST(PulseGrid, ABoardMayPauseAndLoseReports) {
  PulseGrid grid(kPeriod);
  (void)grid.add_reported(0, 0.0, true);
  for (std::int64_t pulse = 1; pulse <= 40; ++pulse) {
    if (pulse == 17 || pulse == 18) continue;
    EXPECT_TRUE(grid.add_reported(pulse, static_cast<double>(pulse) * kPeriod, true));
  }
  EXPECT_NEAR(grid.time_s(17), 17.0 * kPeriod, 1e-9);
  EXPECT_EQ(grid.nearest(18.2 * kPeriod), 18);
  const double later = 40.0 * kPeriod + 12.345;
  EXPECT_TRUE(grid.add_reported(41, later, true));
  EXPECT_NEAR(grid.period_s(), kPeriod, 1e-9);
  EXPECT_EQ(grid.nearest(later + 0.3 * kPeriod), 41);
  EXPECT_EQ(grid.nearest(40.2 * kPeriod), 40);
}

TEST(PulseGrid, ABoardThatWasResetFollowsNothing) {
  PulseGrid grid(kPeriod);
  (void)grid.add_reported(1000, 10.0, true);
  EXPECT_TRUE(grid.add_reported(1001, 10.0 + kPeriod, true));
  EXPECT_TRUE(grid.add_reported(1001, 10.0 + kPeriod, true));  // said twice
  EXPECT_FALSE(grid.add_reported(0, 10.5, true));
  EXPECT_NEAR(grid.time_s(1), 10.5 + kPeriod, 1e-9);
  EXPECT_FALSE(grid.add_reported(1'000'000, 10.6, true));  // counts faster than time allows
  EXPECT_FALSE(grid.add_reported(1'000'001, 10.6, true));  // no time passed
}

}  // namespace
}  // namespace glint
