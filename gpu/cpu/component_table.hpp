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
  std::uint32_t parent;  // itself: this is the root
  std::uint32_t note;    // whatever the owner of the table wants to remember
};

class ComponentTable {
 public:
  explicit ComponentTable(std::size_t slots) : components_(slots) {}

  std::size_t slots() const noexcept { return components_.size(); }
  Component& operator[](std::uint32_t slot) noexcept { return components_[slot]; }

  std::uint32_t root(std::uint32_t slot) noexcept {
    while (components_[slot].parent != slot) {
      components_[slot].parent = components_[components_[slot].parent].parent;
      slot = components_[slot].parent;
    }
    return slot;
  }

  /// Joins two different roots and returns the one that stays: the one that began higher up.
  std::uint32_t join(std::uint32_t a, std::uint32_t b) noexcept {
    if (components_[b].moments.y_min < components_[a].moments.y_min) std::swap(a, b);
    components_[a].moments.merge(components_[b].moments);
    components_[b].parent = a;
    return a;
  }

 private:
  std::vector<Component> components_;
};

}  // namespace glint::gpu
