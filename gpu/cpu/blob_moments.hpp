// SPDX-License-Identifier: MIT
// The integer sums of a blob, what follows from them, and the order in which blobs are returned.
#pragma once

#include <cstdint>

#include "gpu/detector.hpp"

namespace glint::gpu {

/// Longest side of an image for which no second moment leaves 64 bits: the largest is
/// 255 * sum of x^2 <= 85 * kMaxPixels * side^2.
inline constexpr std::uint32_t kMaxSide = 65536;

/// Sums over the pixels of one blob; w = value - limit. Exact, whatever the order of adding.
struct BlobMoments {
  std::uint32_t area = 0, peak = 0;
  std::uint32_t x_min = 0, y_min = 0, x_max = 0, y_max = 0;
  std::uint64_t sum = 0, w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0, wyy = 0;

  /// Adds a blob that turned out to be the same one.
  void merge(const BlobMoments& other) noexcept;
};

/// The order of CameraBlobs: (y_min, x_min, area, sum), and then whatever else tells two blobs apart, so
/// that what is kept when there are too many does not depend on the order in which they were found.
bool before(const BlobMoments& a, const BlobMoments& b) noexcept;

/// Centroid, central moments, flags and undistortion.
BlobRecord to_record(const BlobMoments& blob, std::uint32_t camera, const CameraFormat& format) noexcept;

}  // namespace glint::gpu
