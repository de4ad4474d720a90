// SPDX-License-Identifier: MIT
// Union-find over blobs that are still growing, in a fixed number of slots.
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "gpu/cpu/blob_moments.hpp"

namespace glint::gpu {

/// One growing blob, or a forwarding address to the blob that it became part of.
struct Component {
  BlobMoments moments;
  std::uint32_t parent;    // itself: this is the root
  std::uint32_t last_row;  // lowest row that it reaches
  bool live;               // false: given out already
  bool pinned;             // touches the first row of its band: the band above may still join it to others
};

/// Slots of all bands of one camera, so that blobs of two bands can be joined. A band works on its own
/// slots only until all bands are through.
class ComponentTable {
 public:
  explicit ComponentTable(std::size_t slots) : components_(slots) {}

  Component& operator[](std::uint32_t slot) noexcept { return components_[slot]; }

  std::uint32_t root(std::uint32_t slot) noexcept {
    while (components_[slot].parent != slot) {
      components_[slot].parent = components_[components_[slot].parent].parent;
      slot = components_[slot].parent;
    }
    return slot;
  }

  /// Joins two different roots; the winner comes first. A pinned one wins, so that no pinned slot
  /// forwards to one that is freed.
  std::pair<std::uint32_t, std::uint32_t> join(std::uint32_t a, std::uint32_t b) noexcept {
    if (components_[b].pinned && !components_[a].pinned) std::swap(a, b);
    Component &winner = components_[a], &loser = components_[b];
    winner.moments.merge(loser.moments);
    if (winner.last_row < loser.last_row) winner.last_row = loser.last_row;
    loser.parent = a;
    return {a, b};
  }

 private:
  std::vector<Component> components_;
};

/// The runs of one row (row_kernels.hpp) and the components that they belong to.
struct RowRuns {
  const std::uint32_t* edges = nullptr;
  std::uint32_t* component = nullptr;
  std::size_t count = 0;

  std::uint32_t x_begin(std::size_t run) const noexcept { return edges[2 * run]; }
  std::uint32_t x_end(std::size_t run) const noexcept { return edges[2 * run + 1]; }
};

/// Calls touch(i, j) for every run i of `upper` that is 8-connected to run j of `lower`, the row below.
template <typename Touch>
void for_touching_runs(const RowRuns& upper, const RowRuns& lower, Touch touch) noexcept {
  std::size_t first = 0;
  for (std::size_t j = 0; j < lower.count; ++j) {
    const std::uint32_t begin = lower.x_begin(j), end = lower.x_end(j);
    while (first < upper.count && upper.x_end(first) < begin) ++first;
    for (std::size_t i = first; i < upper.count && upper.x_begin(i) <= end; ++i) touch(i, j);
  }
}

}  // namespace glint::gpu
