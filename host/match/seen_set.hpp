// SPDX-License-Identifier: MIT
// A set of 64-bit hashes that keeps its memory.
#pragma once

#include <cstdint>
#include <vector>

namespace glint {

/// Stands for the set of tuples already tried: a collision of 64-bit hashes is taken as equality (a million
/// tuples collide with a probability of 3e-8).
class SeenSet {
 public:
  void clear() {
    slots_.assign(slots_.size() < 1024 ? 1024 : slots_.size(), 0);
    size_ = 0;
  }
  /// True if `hash` was not yet in the set.
  bool insert(std::uint64_t hash) {
    if (2 * (size_ + 1) > slots_.size()) grow();
    return place(hash == 0 ? 1 : hash);
  }

 private:
  bool place(std::uint64_t hash) noexcept {
    for (std::size_t k = hash & (slots_.size() - 1);; k = (k + 1) & (slots_.size() - 1)) {
      if (slots_[k] == hash) return false;
      if (slots_[k] != 0) continue;
      slots_[k] = hash;
      ++size_;
      return true;
    }
  }
  void grow() {
    old_.swap(slots_);
    slots_.assign(old_.empty() ? 1024 : 2 * old_.size(), 0);
    size_ = 0;
    for (std::uint64_t hash : old_)
      if (hash != 0) place(hash);
  }

  std::vector<std::uint64_t> slots_, old_;  // a power of two
  std::size_t size_ = 0;
};

/// Scrambles a number (splitmix64's finaliser, Steele et al. 2014), so that sums of results tell sets apart.
inline std::uint64_t scramble(std::uint64_t x) noexcept {
  x += 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return x ^ (x >> 31);
}

}  // namespace glint
