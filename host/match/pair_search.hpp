// SPDX-License-Identifier: MIT
// Which blobs of two cameras may be the same marker: their rays must meet.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "host/match/blob_table.hpp"

namespace glint {

/// Two blobs whose rays meet within their uncertainties.
struct BlobPair {
  std::uint32_t a = 0, b = 0;
  Eigen::Vector3d midpoint_in_world;
  double chi2 = 0.0;  ///< of the distance between the rays, one degree of freedom
};

class PairSearch {
 public:
  /// All borrowed for the life of the search.
  PairSearch(std::span<const Camera> cameras, const MatchOptions& options, const BlobTable& table);

  /// Do the rays of two blobs of different cameras meet, in front of both, within the ranges, at a usable
  /// angle?
  std::optional<BlobPair> meet(std::uint32_t a, std::uint32_t b) const noexcept;

  /// Calls visit(const BlobPair&) for every free blob of `camera` that blob `a` meets. Walks the grid cells
  /// along the epipolar line between the ranges, so that the cost grows with the blobs near the line only.
  template <typename Visit>
  void partners(std::uint32_t a, std::size_t camera, Visit&& visit) {
    candidates_.clear();
    collect_along_line(a, camera);
    for (std::uint32_t b : candidates_)
      if (const auto pair = meet(a, b)) visit(*pair);
  }

 private:
  void collect_along_line(std::uint32_t a, std::size_t camera);

  std::span<const Camera> cameras_;
  const MatchOptions& options_;
  const BlobTable& table_;
  std::vector<std::uint32_t> candidates_;
};

}  // namespace glint
