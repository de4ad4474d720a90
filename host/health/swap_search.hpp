// SPDX-License-Identifier: MIT
// Whether two cameras' images are each other's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/health/comparison.hpp"

namespace glint::health {

/// Puts points that owe nothing to two cameras into the calibration of one and looks for them among the blobs
/// of the other. A blob is there by chance once in a thousand times, so a short while is enough.
class SwapSearch {
 public:
  explicit SwapSearch(std::size_t cameras) : cameras_(cameras), tallies_(cameras * cameras) {}

  /// Adds what one exposure tells of the blobs of `images` as seen through the calibration of `lens`.
  void add(std::size_t images, std::size_t lens, double time_s, std::span<const OthersPoint> points,
           std::span<const shaders::BlobRecord> blobs, const ComparedCamera& through) noexcept;
  /// The same where only one other camera is left, which makes no points: looks for triples of its blobs,
  /// those of `a` through the calibration of `b`, and those of `b` through that of `a`, that meet.
  void add_triples(std::size_t a, std::size_t b, std::size_t witness, double time_s,
                   std::span<const std::span<const shaders::BlobRecord>> blobs,
                   std::span<const ComparedCamera> cameras) noexcept;
  /// Both directions fit, by what was added lately.
  bool swapped(std::size_t a, std::size_t b, double time_s) const noexcept;
  void clear() noexcept;

 private:
  struct Tally {
    double time_s = 0.0, tested = 0.0, found = 0.0;  // fading
  };
  const Tally& tally(std::size_t images, std::size_t lens) const noexcept {
    return tallies_[images * cameras_ + lens];
  }
  Tally& fade(std::size_t images, std::size_t lens, double time_s) noexcept;
  bool fits(const Tally& tally, double time_s) const noexcept;

  std::size_t cameras_;
  std::vector<Tally> tallies_;
};

}  // namespace glint::health
