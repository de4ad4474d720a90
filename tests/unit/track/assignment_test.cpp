// SPDX-License-Identifier: MIT
// Assignment against trying all possibilities.
#include "host/track/assignment.hpp"

#include <gtest/gtest.h>

#include <random>

namespace glint {
namespace {

double best_by_trying(std::size_t row, std::size_t rows, std::uint32_t used,
                      const std::vector<std::vector<double>>& gain) {
  if (row == rows) return 0.0;
  double best = best_by_trying(row + 1, rows, used, gain);
  for (std::size_t c = 0; c < gain[row].size(); ++c)
    if (gain[row][c] > 0.0 && (used >> c & 1u) == 0)
      best = std::max(best, gain[row][c] + best_by_trying(row + 1, rows, used | 1u << c, gain));
  return best;
}

TEST(Assignment, IsTheBestOfAllOnRandomProblems) {
  std::mt19937 random(5);
  Assignment assignment;
  std::vector<std::uint32_t> column_of_row;
  for (int trial = 0; trial < 500; ++trial) {
    const std::size_t rows = 1 + random() % 6, columns = 1 + random() % 6;
    std::vector<std::vector<double>> gain(rows, std::vector<double>(columns, 0.0));
    std::vector<AssignmentEdge> edges;
    for (std::uint32_t r = 0; r < rows; ++r)
      for (std::uint32_t c = 0; c < columns; ++c)
        if (random() % 100 < 55) {
          gain[r][c] = 0.1 + static_cast<double>(random() % 1000);
          edges.push_back({r, c, gain[r][c]});
        }
    std::shuffle(edges.begin(), edges.end(), random);
    assignment.solve(rows, columns, edges, column_of_row);
    ASSERT_EQ(column_of_row.size(), rows);
    double sum = 0.0;
    std::uint32_t used = 0;
    for (std::size_t r = 0; r < rows; ++r) {
      const std::uint32_t c = column_of_row[r];
      if (c == kUnassigned) continue;
      ASSERT_GT(gain[r][c], 0.0) << "assigned without an edge";
      ASSERT_EQ(used >> c & 1u, 0u) << "a column twice";
      used |= 1u << c;
      sum += gain[r][c];
    }
    EXPECT_NEAR(sum, best_by_trying(0, rows, 0, gain), 1e-9);
  }
  EXPECT_EQ(assignment.inexact(), 0u);
}

TEST(Assignment, TakesNothingThatIsWorthNothing) {
  Assignment assignment;
  std::vector<std::uint32_t> column_of_row;
  assignment.solve(2, 1, std::vector<AssignmentEdge>{{0, 0, -1.0}, {1, 0, 0.0}}, column_of_row);
  EXPECT_EQ(column_of_row, (std::vector<std::uint32_t>{kUnassigned, kUnassigned}));
  assignment.solve(0, 0, {}, column_of_row);
  EXPECT_TRUE(column_of_row.empty());
}

TEST(Assignment, HugeComponentsAreCountedAndStillOneToOne) {
  constexpr std::uint32_t kSize = 400;
  std::vector<AssignmentEdge> edges;
  for (std::uint32_t r = 0; r < kSize; ++r) {
    edges.push_back({r, r, 2.0});
    edges.push_back({r, (r + 1) % kSize, 1.5});
  }
  Assignment assignment;
  std::vector<std::uint32_t> column_of_row;
  assignment.solve(kSize, kSize, edges, column_of_row);
  EXPECT_EQ(assignment.inexact(), 1u);
  for (std::uint32_t r = 0; r < kSize; ++r) EXPECT_EQ(column_of_row[r], r);
}

}  // namespace
}  // namespace glint
