// SPDX-License-Identifier: MIT
// The first N of any number of blobs, in memory for N.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "gpu/cpu/blob_moments.hpp"

namespace glint::gpu {

/// Counts what it is offered and keeps the first `capacity` in the order of before(). Allocates only
/// when it is made.
class KeepFirst {
 public:
  explicit KeepFirst(std::size_t capacity) : capacity_(capacity) {
    kept_.reserve(capacity);
    places_.reserve(capacity);
  }

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

  /// Calls use(blob) for all that was kept, in order.
  template <typename Use>
  void for_each_in_order(Use use) noexcept {
    places_.clear();
    for (std::uint32_t i = 0; i < kept_.size(); ++i)
      places_.push_back({std::uint64_t{kept_[i].y_min} << 32 | kept_[i].x_min, i});
    std::sort(places_.begin(), places_.end(), [this](const Place& a, const Place& b) {
      return a.y_x != b.y_x ? a.y_x < b.y_x : before(kept_[a.index], kept_[b.index]);
    });
    for (const Place& place : places_) use(kept_[place.index]);
  }

  std::uint32_t offered() const noexcept { return offered_; }

 private:
  struct Place {
    std::uint64_t y_x;  // what before() compares first
    std::uint32_t index;
  };

  std::size_t capacity_;
  std::vector<BlobMoments> kept_;
  std::vector<Place> places_;
  std::uint32_t offered_ = 0;
};

}  // namespace glint::gpu
