// SPDX-License-Identifier: MIT
// Quantiles by hand, and a bootstrap that covers what it claims.
#include "host/bench/statistics.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

namespace glint::bench {
namespace {

TEST(Quantile, InterpolatesBetweenNeighbours) {
  const std::vector<double> values{1.0, 2.0, 4.0, 8.0, 16.0};
  EXPECT_EQ(quantile(values, 0.0), 1.0);
  EXPECT_EQ(quantile(values, 0.5), 4.0);
  EXPECT_EQ(quantile(values, 1.0), 16.0);
  EXPECT_DOUBLE_EQ(quantile(values, 0.9), 8.0 + 0.6 * 8.0);
  EXPECT_EQ(quantile(std::vector<double>{3.0}, 0.99), 3.0);
  EXPECT_EQ(quantile({}, 0.5), 0.0);
}

TEST(Summarize, OneToAHundred) {
  std::vector<double> values;
  for (int i = 100; i >= 1; --i) values.push_back(i);
  const Summary s = summarize(values);
  EXPECT_EQ(s.count, 100u);
  EXPECT_DOUBLE_EQ(s.p50, 50.5);
  EXPECT_DOUBLE_EQ(s.p90, 90.1);
  EXPECT_DOUBLE_EQ(s.p99, 99.01);
  EXPECT_EQ(s.max, 100.0);
  EXPECT_LT(s.median_95.low, 50.5);
  EXPECT_GT(s.median_95.high, 50.5);
}

TEST(Summarize, NothingAndOneSample) {
  EXPECT_EQ(summarize({}).count, 0u);
  const Summary one = summarize(std::vector<double>{0.25});
  EXPECT_EQ(one.p99, 0.25);
  EXPECT_EQ(one.median_95.low, 0.25);
  EXPECT_EQ(one.median_95.high, 0.25);
}

TEST(MedianInterval, IsAPointForConstantSamples) {
  const Interval interval = median_interval(std::vector<double>(500, 1.5));
  EXPECT_EQ(interval.low, 1.5);
  EXPECT_EQ(interval.high, 1.5);
}

TEST(MedianInterval, IsTheSameEachTime) {
  std::mt19937 random(3);
  std::vector<double> samples(300);
  for (double& s : samples) s = static_cast<double>(random());
  const Interval a = median_interval(samples), b = median_interval(samples);
  EXPECT_EQ(a.low, b.low);
  EXPECT_EQ(a.high, b.high);
}

// Of independent samples the median has a standard error of sigma * sqrt(pi / (2 n)).
TEST(MedianInterval, HasTheWidthAndTheCoverageThatTheoryGives) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(10.0, 1.0);
  constexpr int kRuns = 200, kSamples = 400;
  int covered = 0;
  double width = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    std::vector<double> samples(kSamples);
    for (double& s : samples) s = normal(random);
    const Interval interval = median_interval(samples);
    covered += interval.low <= 10.0 && 10.0 <= interval.high ? 1 : 0;
    width += (interval.high - interval.low) / kRuns;
  }
  EXPECT_GE(covered, 0.87 * kRuns);
  EXPECT_LE(covered, 0.99 * kRuns);
  EXPECT_NEAR(width, 2.0 * 1.96 * std::sqrt(1.5708 / kSamples), 0.04);
}

// Slow ticks come in groups: drawing single samples would promise far too much.
TEST(MedianInterval, IsWiderForSamplesThatComeInGroups) {
  std::vector<double> grouped, mixed;
  for (int i = 0; i < 400; ++i) {
    grouped.push_back((i / 40 % 2 == 0 ? 1.0 : 2.0) + 0.001 * (i % 40));
    mixed.push_back((i % 2 == 0 ? 1.0 : 2.0) + 0.001 * (i / 2 % 40));
  }
  grouped.resize(360);  // five slow ... one group more of quick ones
  mixed.resize(360);
  const Interval g = median_interval(grouped), m = median_interval(mixed);
  EXPECT_GT(g.high - g.low, 0.9);
  EXPECT_GT(g.high - g.low, m.high - m.low - 1e-9);
}

}  // namespace
}  // namespace glint::bench
