// SPDX-License-Identifier: MIT
// The first N of any number of blobs, in memory for N.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "gpu/cpu/blob_moments.hpp"

namespace glint::gpu {

/// Counts what it is offered and keeps the first `capacity` in the order of before(). Allocates only
/// when it is made.
class KeepFirst {
 public:
  explicit KeepFirst(std::size_t capacity) : capacity_(capacity) { kept_.reserve(capacity); }

  void clear() noexcept {
    kept_.clear();
    offered_ = 0;
  }

  void offer(const BlobMoments& blob) noexcept {
    ++offered_;
    if (kept_.size() < capacity_) {
      kept_.push_back(blob);
      // From now on the last of those kept is at the front, to be replaced.
      if (kept_.size() == capacity_) std::make_heap(kept_.begin(), kept_.end(), before);
    } else if (before(blob, kept_.front())) {
      std::pop_heap(kept_.begin(), kept_.end(), before);
      kept_.back() = blob;
      std::push_heap(kept_.begin(), kept_.end(), before);
    }
  }

  /// Takes over what another one kept and counted.
  void offer_all(const KeepFirst& other) noexcept {
    const std::uint32_t not_kept = other.offered_ - static_cast<std::uint32_t>(other.kept_.size());
    for (const BlobMoments& blob : other.kept_) offer(blob);
    offered_ += not_kept;
  }

  /// Ends the keeping: what was kept, in order.
  std::span<const BlobMoments> sorted() noexcept {
    std::sort(kept_.begin(), kept_.end(), before);
    return kept_;
  }

  std::uint32_t offered() const noexcept { return offered_; }

 private:
  std::size_t capacity_;
  std::vector<BlobMoments> kept_;
  std::uint32_t offered_ = 0;
};

}  // namespace glint::gpu
