// SPDX-License-Identifier: MIT
// Set packing against trying all subsets; large components stay disjoint and close to the best.
#include "host/match/set_packing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace glint {
namespace {

struct Problem {
  std::vector<std::vector<std::uint32_t>> sets;
  std::vector<double> scores;
  std::size_t elements = 0;
};

double best_by_trying(const Problem& p, std::size_t k, std::uint64_t used) {
  if (k == p.sets.size()) return 0.0;
  double best = best_by_trying(p, k + 1, used);
  std::uint64_t own = 0;
  for (std::uint32_t e : p.sets[k]) own |= std::uint64_t{1} << e;
  if ((own & used) == 0 && p.scores[k] > 0.0)
    best = std::max(best, p.scores[k] + best_by_trying(p, k + 1, used | own));
  return best;
}

Problem random_problem(std::mt19937& random, std::size_t sets, std::size_t elements) {
  Problem p;
  p.elements = elements;
  for (std::size_t k = 0; k < sets; ++k) {
    std::vector<std::uint32_t> set;
    const std::size_t size = 1 + random() % 4;
    while (set.size() < size) {
      const auto e = static_cast<std::uint32_t>(random() % elements);
      if (std::find(set.begin(), set.end(), e) == set.end()) set.push_back(e);
    }
    p.sets.push_back(set);
    p.scores.push_back(static_cast<double>(random() % 1000) - 50.0);
  }
  return p;
}

double solve(SetPacking& packing, const Problem& p, SetPacking::Counters& counters) {
  packing.reset(p.elements);
  for (std::size_t k = 0; k < p.sets.size(); ++k) packing.add(p.sets[k], p.scores[k]);
  std::vector<std::uint32_t> chosen;
  packing.solve(chosen, counters);
  std::vector<bool> used(p.elements, false);
  double sum = 0.0;
  for (std::uint32_t k : chosen) {
    EXPECT_GT(p.scores[k], 0.0);
    sum += p.scores[k];
    for (std::uint32_t e : p.sets[k]) {
      EXPECT_FALSE(used[e]) << "element " << e << " twice";
      used[e] = true;
    }
  }
  return sum;
}

TEST(SetPacking, IsTheBestOfAllOnRandomProblems) {
  std::mt19937 random(11);
  SetPacking packing;
  SetPacking::Counters counters;
  for (int trial = 0; trial < 400; ++trial) {
    const Problem p = random_problem(random, 1 + random() % 16, 4 + random() % 16);
    EXPECT_NEAR(solve(packing, p, counters), best_by_trying(p, 0, 0), 1e-9);
  }
  EXPECT_EQ(counters.inexact, 0u);
  EXPECT_EQ(counters.exact, counters.components);
}

TEST(SetPacking, BestFirstAloneWouldBeWrong) {
  // The best set blocks two that are together worth more.
  SetPacking packing;
  SetPacking::Counters counters;
  EXPECT_EQ(solve(packing, {{{0, 1}, {0}, {1}}, {10.0, 7.0, 8.0}, 2}, counters), 15.0);
}

TEST(SetPacking, LargeComponentsAreCountedAndImprovedByExchange) {
  // A chain of 200 triples (a pair that blocks its two single neighbours), all connected.
  Problem p;
  p.elements = 400;
  for (std::uint32_t k = 0; k + 1 < p.elements; ++k) {
    p.sets.push_back({k, k + 1});
    p.scores.push_back(10.0);
  }
  for (std::uint32_t k = 0; k < p.elements; ++k) {
    p.sets.push_back({k});
    p.scores.push_back(7.0);
  }
  SetPacking packing;
  SetPacking::Counters counters;
  EXPECT_EQ(solve(packing, p, counters), 400 * 7.0);
  EXPECT_EQ(counters.components, 1u);
  EXPECT_EQ(counters.inexact, 1u);
}

TEST(SetPacking, LargeRandomComponentsReachWhatSmallOnesDo) {
  // Sixteen independent problems, solved exactly one by one, against the same tied together by worthless
  // bridges.
  std::mt19937 random(12);
  SetPacking packing;
  double alone = 0.0;
  Problem tied;
  SetPacking::Counters counters;
  for (int part = 0; part < 16; ++part) {
    const Problem p = random_problem(random, 14, 12);
    alone += solve(packing, p, counters);
    for (std::size_t k = 0; k < p.sets.size(); ++k) {
      auto set = p.sets[k];
      for (std::uint32_t& e : set) e += static_cast<std::uint32_t>(tied.elements);
      tied.sets.push_back(set);
      tied.scores.push_back(p.scores[k]);
    }
    tied.elements += p.elements;
    if (part > 0) {
      tied.sets.push_back({static_cast<std::uint32_t>(tied.elements - p.elements - 1),
                           static_cast<std::uint32_t>(tied.elements - p.elements)});
      tied.scores.push_back(1e-6);
    }
  }
  EXPECT_GE(solve(packing, tied, counters), 0.95 * alone);
  EXPECT_GE(counters.inexact, 1u);
}

TEST(SetPacking, NothingIsFine) {
  SetPacking packing;
  SetPacking::Counters counters;
  EXPECT_EQ(solve(packing, {{}, {}, 0}, counters), 0.0);
  EXPECT_EQ(solve(packing, {{{0}}, {-1.0}, 1}, counters), 0.0);
}

}  // namespace
}  // namespace glint
