// SPDX-License-Identifier: MIT
// Verdicts only outside the noise of both, and only between what belongs together.
#include "host/bench/compare.hpp"

#include <gtest/gtest.h>

#include "tests/unit/bench/sample_results.hpp"

namespace glint::bench {
namespace {

using test::sample_results;
using test::series_around;

TEST(Compare, SaysFasterOrSlowerWhereIntervalsAreApart) {
  const Summary old = series_around(1e-3, 0.02e-3).summary;
  const auto faster = compare(series_around(0.8e-3, 0.02e-3).summary, old);
  ASSERT_TRUE(faster);
  EXPECT_EQ(faster->verdict, Verdict::Faster);
  EXPECT_NEAR(faster->ratio, 0.8, 1e-6);
  EXPECT_EQ(faster->old_p50, old.p50);
  const auto slower = compare(series_around(1.5e-3, 0.02e-3).summary, old);
  ASSERT_TRUE(slower);
  EXPECT_EQ(slower->verdict, Verdict::Slower);
  EXPECT_STREQ(text(slower->verdict), "slower");
}

TEST(Compare, SaysNothingWhereIntervalsOverlap) {
  const Summary old = series_around(1e-3, 0.5e-3).summary;
  const auto change = compare(series_around(0.97e-3, 0.5e-3).summary, old);
  ASSERT_TRUE(change);
  EXPECT_EQ(change->verdict, Verdict::SameWithinNoise);
  EXPECT_STREQ(text(change->verdict), "same within noise");
}

TEST(Compare, WithItselfIsTheSame) {
  const Summary s = series_around(1e-3, 0.01e-3).summary;
  EXPECT_EQ(compare(s, s)->verdict, Verdict::SameWithinNoise);
  EXPECT_EQ(compare(s, s)->ratio, 1.0);
}

TEST(Compare, NeedsSamplesOnBothSides) {
  EXPECT_FALSE(compare({}, series_around(1e-3, 1e-5).summary));
  EXPECT_FALSE(compare(series_around(1e-3, 1e-5).summary, {}));
}

TEST(MatchingRow, GoesByDeviceAndScene) {
  const Results r = sample_results();
  const SceneKey dark{4, 1280, 800, 0, 1.2};
  ASSERT_NE(matching_row(r, "llvmpipe", dark), nullptr);
  EXPECT_NEAR(matching_row(r, "llvmpipe", dark)->wall.summary.p50, 0.5e-3, 1e-9);
  EXPECT_NEAR(matching_row(r, "cpu (8 threads, AVX2)", dark)->wall.summary.p50, 0.05e-3, 1e-9);
  EXPECT_EQ(matching_row(r, "llvmpip", dark), nullptr);
  EXPECT_EQ(matching_row(r, "llvmpipe", {4, 1280, 800, 0, 1.3}), nullptr);
  EXPECT_EQ(matching_row(r, "Wrong GPU, fast", dark), nullptr) << "it has no figures";
}

TEST(ChangeOf, FindsStagesByName) {
  const Results r = sample_results();
  const Row& row = r.devices[0].rows[0];
  const auto same = change_of("stage blobs", row.stages[1].time, &row);
  ASSERT_TRUE(same);
  EXPECT_EQ(same->ratio, 1.0);
  EXPECT_FALSE(change_of("stage gone", row.stages[1].time, &row));
  EXPECT_FALSE(change_of("wall", row.wall, nullptr));
}

}  // namespace
}  // namespace glint::bench
