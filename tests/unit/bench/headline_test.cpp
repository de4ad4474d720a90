// SPDX-License-Identifier: MIT
// The bisection finds the edge wherever it is.
#include "host/bench/headline.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace glint::bench {
namespace {

/// In time up to `edge` cameras.
Headline search_for_edge(unsigned edge, unsigned most, std::vector<unsigned>* tried = nullptr) {
  return search_headline(90.0, most, [&](unsigned cameras) {
    EXPECT_GE(cameras, 1u);
    EXPECT_LE(cameras, most);
    if (tried != nullptr) tried->push_back(cameras);
    return Attempt{cameras <= edge, 1e-3 * cameras, Outcome::Ok, ""};
  });
}

TEST(Headline, FindsEveryEdge) {
  for (const unsigned most : {1u, 2u, 7u, 32u}) {
    for (unsigned edge = 0; edge <= most; ++edge) {
      const Headline headline = search_for_edge(edge, most);
      EXPECT_EQ(headline.cameras, edge) << "of " << most;
      EXPECT_EQ(headline.outcome, Outcome::Ok);
      EXPECT_EQ(headline.at_limit, edge == 32);
      EXPECT_DOUBLE_EQ(headline.p99_s, 1e-3 * edge);
    }
  }
}

TEST(Headline, TriesFewNumbers) {
  std::vector<unsigned> tried;
  search_for_edge(32, 32, &tried);
  EXPECT_EQ(tried, std::vector<unsigned>{32});
  for (unsigned edge = 0; edge < 32; ++edge) {
    tried.clear();
    search_for_edge(edge, 32, &tried);
    EXPECT_LE(tried.size(), 7u);
  }
}

TEST(Headline, IsNoneForAWrongDevice) {
  const Headline headline = search_headline(90.0, 32, [](unsigned cameras) {
    return cameras > 20 ? Attempt{false, 0.02, Outcome::Ok, ""}
                        : Attempt{true, 0.001, Outcome::Wrong, "differs"};
  });
  EXPECT_EQ(headline.outcome, Outcome::Wrong);
  EXPECT_EQ(headline.problem, "differs");
  EXPECT_EQ(headline.cameras, 0u);
}

TEST(Headline, TakesMoreThanFitsForTooMany) {
  const auto up_to = [](unsigned fits) {
    return search_headline(90.0, 32, [=](unsigned cameras) {
      return cameras <= fits ? Attempt{true, 0.001, Outcome::Ok, ""}
                             : Attempt{false, 0.0, Outcome::Failed, "no memory"};
    });
  };
  EXPECT_EQ(up_to(12).cameras, 12u);
  EXPECT_EQ(up_to(12).outcome, Outcome::Ok);
  EXPECT_EQ(up_to(12).problem, "no memory");
  EXPECT_EQ(up_to(0).outcome, Outcome::Failed);
  EXPECT_EQ(up_to(0).problem, "no memory");
}

}  // namespace
}  // namespace glint::bench
