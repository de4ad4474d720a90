// SPDX-License-Identifier: MIT
// Assignment by components and shortest augmenting paths.
#include "host/track/assignment.hpp"

#include <algorithm>
#include <numeric>

namespace glint {
namespace {

constexpr std::size_t kExactRows = 256;  // 256 rows take about 10 ms when everything is near everything

}  // namespace

std::uint32_t Assignment::root(std::uint32_t node) noexcept {
  while (parent_[node] != node) {
    parent_[node] = parent_[parent_[node]];
    node = parent_[node];
  }
  return node;
}

void Assignment::solve(std::size_t rows, std::size_t columns, std::span<const AssignmentEdge> edges,
                       std::vector<std::uint32_t>& column_of_row) {
  column_of_row.assign(rows, kUnassigned);
  parent_.resize(rows + columns);
  std::iota(parent_.begin(), parent_.end(), 0u);
  local_.resize(rows + columns);
  column_used_.assign(columns, 0);
  const auto offset = static_cast<std::uint32_t>(rows);
  edges_.clear();
  for (const AssignmentEdge& edge : edges) {
    if (!(edge.gain > 0.0)) continue;
    edges_.push_back(edge);
    const std::uint32_t a = root(edge.row), b = root(offset + edge.column);
    parent_[std::max(a, b)] = std::min(a, b);
  }
  std::sort(edges_.begin(), edges_.end(), [this](const AssignmentEdge& a, const AssignmentEdge& b) {
    const std::uint32_t ra = root(a.row), rb = root(b.row);
    if (ra != rb) return ra < rb;
    return a.row != b.row ? a.row < b.row : a.column < b.column;
  });
  for (std::size_t begin = 0; begin < edges_.size();) {
    std::size_t end = begin + 1;
    while (end < edges_.size() && root(edges_[end].row) == root(edges_[begin].row)) ++end;
    const std::span<AssignmentEdge> part(edges_.data() + begin, end - begin);
    begin = end;
    if (part.size() == 1) {
      column_of_row[part[0].row] = part[0].column;
      continue;
    }
    rows_.clear();
    columns_.clear();
    for (const AssignmentEdge& edge : part) {
      if (rows_.empty() || rows_.back() != edge.row) rows_.push_back(edge.row);
      columns_.push_back(edge.column);
    }
    std::sort(columns_.begin(), columns_.end());
    columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
    if (rows_.size() > kExactRows) {
      ++inexact_;
      solve_best_first(part, column_of_row);
    } else {
      solve_component(part, column_of_row);
    }
  }
}

void Assignment::solve_best_first(std::span<AssignmentEdge> edges,
                                  std::vector<std::uint32_t>& column_of_row) {
  std::sort(edges.begin(), edges.end(), [](const AssignmentEdge& a, const AssignmentEdge& b) {
    if (a.gain != b.gain) return a.gain > b.gain;
    return a.row != b.row ? a.row < b.row : a.column < b.column;
  });
  for (const AssignmentEdge& edge : edges) {
    if (column_of_row[edge.row] != kUnassigned || column_used_[edge.column] != 0) continue;
    column_of_row[edge.row] = edge.column;
    column_used_[edge.column] = 1;
  }
}

// Costs are -gain; column m + r is row r's own "stays alone" at cost 0, so that every row gets a column.
void Assignment::solve_component(std::span<const AssignmentEdge> edges,
                                 std::vector<std::uint32_t>& column_of_row) {
  const std::size_t n = rows_.size(), m = columns_.size();
  for (std::uint32_t k = 0; k < n; ++k) local_[rows_[k]] = k;
  gain_.assign(n * m, 0.0);
  for (const AssignmentEdge& edge : edges) {
    const auto column = static_cast<std::size_t>(
        std::lower_bound(columns_.begin(), columns_.end(), edge.column) - columns_.begin());
    double& gain = gain_[local_[edge.row] * m + column];
    gain = std::max(gain, edge.gain);
  }
  row_price_.assign(n, 0.0);
  column_price_.assign(m + n, 0.0);
  row_of_column_.assign(m + n, kUnassigned);
  for (std::size_t row = 0; row < n; ++row) augment(row, n, m);
  for (std::size_t column = 0; column < m; ++column) {
    const std::uint32_t row = row_of_column_[column];
    // A gain of nothing is no edge: the row stays alone.
    if (row != kUnassigned && gain_[row * m + column] > 0.0) column_of_row[rows_[row]] = columns_[column];
  }
}

// Dijkstra over the columns from one free row, with prices that keep reduced costs >= 0.
void Assignment::augment(std::size_t row, std::size_t row_count, std::size_t column_count) {
  constexpr double kFar = std::numeric_limits<double>::infinity();
  const std::size_t total = column_count + row_count;
  const auto cost = [&](std::size_t r, std::size_t c) {
    if (c < column_count) return gain_[r * column_count + c] > 0.0 ? -gain_[r * column_count + c] : 0.0;
    return c - column_count == r ? 0.0 : kFar;
  };
  slack_.assign(total, kFar);
  previous_.assign(total, kUnassigned);
  done_.assign(total, 0);
  std::size_t current_row = row, end = total;
  std::uint32_t from = kUnassigned;  // the column through which current_row was reached
  double reached = 0.0;
  while (end == total) {
    std::size_t next = total;
    double nearest = kFar;
    for (std::size_t c = 0; c < total; ++c) {
      if (done_[c] != 0) continue;
      const double through = reached + cost(current_row, c) - row_price_[current_row] - column_price_[c];
      if (through < slack_[c]) {
        slack_[c] = through;
        previous_[c] = from;
      }
      if (slack_[c] < nearest) {
        nearest = slack_[c];
        next = c;
      }
    }
    reached = nearest;
    done_[next] = 1;
    if (row_of_column_[next] == kUnassigned) {
      end = next;
    } else {
      current_row = row_of_column_[next];
      from = static_cast<std::uint32_t>(next);
    }
  }
  row_price_[row] += reached;
  for (std::size_t c = 0; c < total; ++c) {
    if (done_[c] == 0 || c == end) continue;
    column_price_[c] -= reached - slack_[c];
    row_price_[row_of_column_[c]] += reached - slack_[c];
  }
  for (std::size_t c = end;;) {
    const std::uint32_t before = previous_[c];
    if (before == kUnassigned) {
      row_of_column_[c] = static_cast<std::uint32_t>(row);
      break;
    }
    row_of_column_[c] = row_of_column_[before];
    c = before;
  }
}

}  // namespace glint
