// SPDX-License-Identifier: MIT
// One-to-one assignment of rows to columns with the largest sum of gains; either may stay alone.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace glint {

/// Row `row` may go with column `column`, which is worth `gain` > 0 more than leaving both alone.
struct AssignmentEdge {
  std::uint32_t row = 0, column = 0;
  double gain = 0.0;
};

inline constexpr std::uint32_t kUnassigned = std::numeric_limits<std::uint32_t>::max();

/// Splits the problem into connected components and solves each with shortest augmenting paths (Jonker and
/// Volgenant, Computing 38, 1987). Components above 256 rows are solved best-first and counted. Keeps its
/// memory.
class Assignment {
 public:
  /// column_of_row is resized to `rows`.
  void solve(std::size_t rows, std::size_t columns, std::span<const AssignmentEdge> edges,
             std::vector<std::uint32_t>& column_of_row);
  /// Components so far that were not solved exactly.
  std::uint64_t inexact() const noexcept { return inexact_; }

 private:
  std::uint32_t root(std::uint32_t node) noexcept;
  void solve_component(std::span<const AssignmentEdge> edges, std::vector<std::uint32_t>& column_of_row);
  void solve_best_first(std::span<AssignmentEdge> edges, std::vector<std::uint32_t>& column_of_row);
  void augment(std::size_t row, std::size_t row_count, std::size_t column_count);

  std::vector<AssignmentEdge> edges_;
  std::vector<std::uint32_t> parent_;          // rows, then columns
  std::vector<std::uint32_t> local_;           // number of a node within its component
  std::vector<std::uint32_t> rows_, columns_;  // of the component
  std::vector<double> gain_;                   // dense, of the component
  std::vector<double> row_price_, column_price_, slack_;
  std::vector<std::uint32_t> row_of_column_, previous_;
  std::vector<std::uint8_t> done_, column_used_;
  std::uint64_t inexact_ = 0;
};

}  // namespace glint
