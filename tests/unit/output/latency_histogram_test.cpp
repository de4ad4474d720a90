// SPDX-License-Identifier: MIT
// Quantiles from bins agree with those of the sorted values.
#include "host/output/latency_histogram.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace glint {
namespace {

TEST(LatencyHistogram, IsZeroWhenEmpty) {
  const LatencyHistogram h;
  EXPECT_EQ(h.count(), 0u);
  EXPECT_EQ(h.quantile_s(0.5), 0.0);
  EXPECT_EQ(h.max_s(), 0.0);
}

TEST(LatencyHistogram, QuantilesAreRightToABin) {
  std::mt19937 random(7);
  for (const double sigma : {0.01, 0.3, 2.0}) {
    std::lognormal_distribution<double> values(std::log(2e-3), sigma);
    LatencyHistogram h;
    std::vector<double> all;
    for (int i = 0; i < 5001; ++i) {
      all.push_back(values(random));
      h.add(all.back());
    }
    std::sort(all.begin(), all.end());
    for (const double q : {0.01, 0.25, 0.5, 0.9, 0.99, 0.999}) {
      const double exact = all[static_cast<std::size_t>(std::ceil(q * 5001.0)) - 1];
      EXPECT_NEAR(h.quantile_s(q) / exact, 1.0, 0.0065) << "q " << q << " sigma " << sigma;
    }
    EXPECT_EQ(h.quantile_s(1.0), all.back());
    EXPECT_EQ(h.max_s(), all.back());
    EXPECT_EQ(h.min_s(), all.front());
    EXPECT_EQ(h.count_between(0.0, 1e9), 5001u);
  }
}

TEST(LatencyHistogram, OneValueIsItsOwnQuantiles) {
  LatencyHistogram h;
  h.add(3.3e-3);
  EXPECT_EQ(h.quantile_s(0.0), 3.3e-3);
  EXPECT_EQ(h.quantile_s(0.5), 3.3e-3);
  EXPECT_EQ(h.quantile_s(1.0), 3.3e-3);
}

TEST(LatencyHistogram, LeavesOutWhatIsNoDuration) {
  LatencyHistogram h;
  h.add(-1.0);
  h.add(std::numeric_limits<double>::quiet_NaN());
  h.add(std::numeric_limits<double>::infinity());
  EXPECT_EQ(h.count(), 0u);
  h.add(0.0);
  h.add(1e9);  // beyond the last bin: still counted, and the maximum is exact
  EXPECT_EQ(h.count(), 2u);
  EXPECT_EQ(h.max_s(), 1e9);
}

}  // namespace
}  // namespace glint
