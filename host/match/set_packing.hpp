// SPDX-License-Identifier: MIT
// Weighted set packing: of sets with scores, the disjoint ones with the largest sum of scores.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace glint {

/// Correspondence as an optimisation problem: a set is a hypothesis ("these blobs and this track are one
/// marker"), its elements are the blobs, of which each may be used once. The problem falls into connected
/// components; each is solved exactly by branch and bound while it is small, else best-first followed by
/// exchanges. Keeps its memory.
class SetPacking {
 public:
  struct Counters {
    std::uint64_t components = 0, exact = 0, inexact = 0;
  };

  /// Forgets all sets; elements are numbered 0 .. elements-1.
  void reset(std::size_t elements);
  /// Adds set number size(); only sets with a score > 0 are ever chosen.
  void add(std::span<const std::uint32_t> elements, double score);
  std::size_t size() const noexcept { return scores_.size(); }
  /// Numbers of the chosen sets, in no particular order; adds to `counters`.
  void solve(std::vector<std::uint32_t>& chosen, Counters& counters);

 private:
  std::span<const std::uint32_t> elements_of(std::uint32_t set) const noexcept {
    return {members_.data() + first_[set], members_.data() + first_[set + 1]};
  }
  std::uint32_t root(std::uint32_t element) noexcept;
  void solve_exact(std::span<const std::uint32_t> sets, std::vector<std::uint32_t>& chosen,
                   Counters& counters);
  void solve_best_first(std::span<const std::uint32_t> sets, std::vector<std::uint32_t>& chosen);
  bool exchange(std::span<const std::uint32_t> sets);
  void branch(std::uint64_t remaining, std::uint64_t taken, double score) noexcept;
  double bound(std::uint64_t remaining) const noexcept;
  void take(std::uint32_t set) noexcept;
  void drop(std::uint32_t set) noexcept;
  double score_in_the_way(std::uint32_t set) const noexcept;

  std::vector<std::uint32_t> members_, first_{0};
  std::vector<double> scores_;
  std::vector<std::uint32_t> parent_, owner_;  // by element
  std::vector<std::uint32_t> order_, component_of_;
  std::vector<std::uint32_t> users_first_, users_, touched_;  // sets of each element
  std::vector<std::uint8_t> in_use_;                          // by set

  // Of the component that is being solved exactly.
  std::vector<std::uint64_t> conflicts_;
  std::vector<double> component_scores_;
  std::uint64_t best_taken_ = 0;
  double best_score_ = 0.0;
  std::uint32_t nodes_left_ = 0;
};

}  // namespace glint
