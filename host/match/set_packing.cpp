// SPDX-License-Identifier: MIT
// Branch and bound for small components, best-first with exchanges for large ones.
#include "host/match/set_packing.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace glint {
namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
constexpr std::size_t kExactSets = 64;        // one machine word per row of the conflict matrix
constexpr std::uint32_t kBranchNodes = 5000;  // a few milliseconds; real components need fewer than 100
constexpr int kExchangeRounds = 20;           // three rounds are the most seen to improve anything

}  // namespace

void SetPacking::reset(std::size_t elements) {
  members_.clear();
  first_.assign(1, 0);
  scores_.clear();
  parent_.resize(elements);
  std::iota(parent_.begin(), parent_.end(), 0u);
  owner_.assign(elements, kNone);
}

std::uint32_t SetPacking::root(std::uint32_t element) noexcept {
  while (parent_[element] != element) {
    parent_[element] = parent_[parent_[element]];
    element = parent_[element];
  }
  return element;
}

void SetPacking::add(std::span<const std::uint32_t> elements, double score) {
  scores_.push_back(score);
  members_.insert(members_.end(), elements.begin(), elements.end());
  first_.push_back(static_cast<std::uint32_t>(members_.size()));
  if (!(score > 0.0)) return;  // never chosen, so it connects nothing
  for (std::size_t k = 1; k < elements.size(); ++k) {
    const std::uint32_t a = root(elements[0]), b = root(elements[k]);
    parent_[std::max(a, b)] = std::min(a, b);
  }
}

void SetPacking::solve(std::vector<std::uint32_t>& chosen, Counters& counters) {
  chosen.clear();
  order_.clear();
  component_of_.resize(size());
  for (std::uint32_t set = 0; set < size(); ++set) {
    const auto elements = elements_of(set);
    if (!(scores_[set] > 0.0) || elements.empty()) continue;
    component_of_[set] = root(elements[0]);
    order_.push_back(set);
  }
  // By component, best first; ties by the sets' own numbers so that equal input gives equal output.
  std::sort(order_.begin(), order_.end(), [this](std::uint32_t a, std::uint32_t b) {
    if (component_of_[a] != component_of_[b]) return component_of_[a] < component_of_[b];
    if (scores_[a] != scores_[b]) return scores_[a] > scores_[b];
    return a < b;
  });
  in_use_.assign(size(), 0);
  for (std::size_t begin = 0; begin < order_.size();) {
    std::size_t end = begin + 1;
    while (end < order_.size() && component_of_[order_[end]] == component_of_[order_[begin]]) ++end;
    const std::span<const std::uint32_t> sets(order_.data() + begin, end - begin);
    ++counters.components;
    if (sets.size() == 1) {
      chosen.push_back(sets[0]);
      ++counters.exact;
    } else if (sets.size() <= kExactSets) {
      solve_exact(sets, chosen, counters);
    } else {
      solve_best_first(sets, chosen);
      ++counters.inexact;
    }
    begin = end;
  }
}

void SetPacking::solve_exact(std::span<const std::uint32_t> sets, std::vector<std::uint32_t>& chosen,
                             Counters& counters) {
  const std::size_t n = sets.size();
  conflicts_.assign(n, 0);
  component_scores_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    component_scores_[i] = scores_[sets[i]];
    const auto a = elements_of(sets[i]);
    for (std::size_t j = i + 1; j < n; ++j) {
      const auto b = elements_of(sets[j]);
      const bool meet = std::any_of(a.begin(), a.end(), [b](std::uint32_t element) {
        return std::find(b.begin(), b.end(), element) != b.end();
      });
      if (!meet) continue;
      conflicts_[i] |= std::uint64_t{1} << j;
      conflicts_[j] |= std::uint64_t{1} << i;
    }
  }
  best_taken_ = 0;
  best_score_ = 0.0;
  nodes_left_ = kBranchNodes;
  const std::uint64_t all = n == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << n) - 1;
  branch(all, 0, 0.0);
  if (nodes_left_ == 0) {
    ++counters.inexact;  // the budget ran out; start the exchanges from the best so far
    for (std::size_t i = 0; i < n; ++i)
      if ((best_taken_ >> i & 1u) != 0) take(sets[i]);
    solve_best_first(sets, chosen);
    return;
  }
  ++counters.exact;
  for (std::size_t i = 0; i < n; ++i)
    if ((best_taken_ >> i & 1u) != 0) chosen.push_back(sets[i]);
}

// An upper bound: the sets are covered by cliques of the conflict graph, of each of which one set can be
// taken at most. They come best first, so that a clique's first set is its largest.
double SetPacking::bound(std::uint64_t remaining) const noexcept {
  double sum = 0.0;
  while (remaining != 0) {
    const auto first = static_cast<std::size_t>(std::countr_zero(remaining));
    sum += component_scores_[first];
    remaining &= remaining - 1;
    std::uint64_t common = remaining & conflicts_[first];
    while (common != 0) {
      const auto next = static_cast<std::size_t>(std::countr_zero(common));
      remaining &= ~(std::uint64_t{1} << next);
      common &= conflicts_[next] & remaining;
    }
  }
  return sum;
}

void SetPacking::branch(std::uint64_t remaining, std::uint64_t taken, double score) noexcept {
  if (score > best_score_) {
    best_score_ = score;
    best_taken_ = taken;
  }
  while (remaining != 0) {
    if (nodes_left_ == 0) return;
    --nodes_left_;
    if (score + bound(remaining) <= best_score_) return;
    const auto first = static_cast<std::size_t>(std::countr_zero(remaining));
    remaining &= remaining - 1;
    branch(remaining & ~conflicts_[first], taken | std::uint64_t{1} << first,
           score + component_scores_[first]);
  }
}

void SetPacking::take(std::uint32_t set) noexcept {
  for (std::uint32_t element : elements_of(set)) {
    if (owner_[element] != kNone) drop(owner_[element]);
    owner_[element] = set;
  }
  in_use_[set] = 1;
}

void SetPacking::drop(std::uint32_t set) noexcept {
  for (std::uint32_t element : elements_of(set))
    if (owner_[element] == set) owner_[element] = kNone;
  in_use_[set] = 0;
}

double SetPacking::score_in_the_way(std::uint32_t set) const noexcept {
  double sum = 0.0;
  const auto elements = elements_of(set);
  for (std::size_t k = 0; k < elements.size(); ++k) {
    const std::uint32_t owner = owner_[elements[k]];
    if (owner == kNone) continue;
    bool counted = false;
    for (std::size_t before = 0; before < k; ++before) counted = counted || owner_[elements[before]] == owner;
    if (!counted) sum += scores_[owner];
  }
  return sum;
}

// One round: a set goes in where it is worth more than what it displaces; then one set goes out where several
// that it alone keeps out are together worth more.
bool SetPacking::exchange(std::span<const std::uint32_t> sets) {
  bool improved = false;
  for (std::uint32_t set : sets)
    if (in_use_[set] == 0 && scores_[set] > score_in_the_way(set) * (1.0 + 1e-12)) {
      take(set);
      improved = true;
    }
  for (std::uint32_t set : sets) {
    if (in_use_[set] == 0) continue;
    drop(set);
    double gained = 0.0;
    touched_.clear();
    for (std::uint32_t element : elements_of(set))
      for (std::uint32_t k = users_first_[element]; k < users_first_[element + 1]; ++k) {
        const std::uint32_t other = users_[k];
        if (other == set || in_use_[other] != 0 || score_in_the_way(other) > 0.0) continue;
        take(other);
        touched_.push_back(other);
        gained += scores_[other];
      }
    if (gained > scores_[set] * (1.0 + 1e-12)) {
      improved = true;
    } else {
      for (std::uint32_t other : touched_) drop(other);
      take(set);
    }
  }
  return improved;
}

void SetPacking::solve_best_first(std::span<const std::uint32_t> sets, std::vector<std::uint32_t>& chosen) {
  // Which sets use an element, best first; only this component's lists are filled.
  users_first_.assign(owner_.size() + 1, 0);
  for (std::uint32_t set : sets)
    for (std::uint32_t element : elements_of(set)) ++users_first_[element + 1];
  std::partial_sum(users_first_.begin(), users_first_.end(), users_first_.begin());
  users_.resize(users_first_.back());
  for (auto set = sets.rbegin(); set != sets.rend(); ++set)
    for (std::uint32_t element : elements_of(*set)) users_[--users_first_[element + 1]] = *set;
  // The counting-down has moved every start one place: start of element e now stands at e + 1.
  users_first_.erase(users_first_.begin());
  users_first_.push_back(static_cast<std::uint32_t>(users_.size()));

  for (std::uint32_t set : sets)
    if (in_use_[set] == 0 && score_in_the_way(set) == 0.0) take(set);
  for (int round = 0; round < kExchangeRounds && exchange(sets); ++round) {
  }
  for (std::uint32_t set : sets)
    if (in_use_[set] != 0) chosen.push_back(set);
}

}  // namespace glint
