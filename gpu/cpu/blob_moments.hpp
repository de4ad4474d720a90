// SPDX-License-Identifier: MIT
// The integer sums of a blob, what follows from them, and the order in which blobs are returned.
#pragma once

#include <algorithm>
#include <cstdint>

#include "gpu/lens.hpp"

namespace glint::gpu {

/// Longest side of an image for which no second moment leaves 64 bits: the largest is
/// 255 * sum of x^2 <= 85 * kMaxPixels * side^2.
inline constexpr std::uint32_t kMaxSide = 65536;

/// Sums over the pixels of one blob; w = value - limit. Exact, whatever the order of adding.
struct BlobMoments {
  std::uint64_t sum = 0, w = 0, wx = 0, wy = 0, wxx = 0, wxy = 0, wyy = 0;
  std::uint32_t area = 0, peak = 0;
  std::uint32_t x_min = 0, y_min = 0, x_max = 0, y_max = 0;

  /// Adds a blob that turned out to be the same one.
  void merge(const BlobMoments& other) noexcept {
    y_min = std::min(y_min, other.y_min);
    y_max = std::max(y_max, other.y_max);
    append(other);
  }
  /// Adds what lies in row y_max, but does not begin higher up.
  void append(const BlobMoments& other) noexcept {
    sum += other.sum;
    w += other.w;
    wx += other.wx;
    wy += other.wy;
    wxx += other.wxx;
    wxy += other.wxy;
    wyy += other.wyy;
    area += other.area;
    peak = std::max(peak, other.peak);
    x_min = std::min(x_min, other.x_min);
    x_max = std::max(x_max, other.x_max);
  }
};

/// The order of CameraBlobs: (y_min, x_min, area, sum), and then whatever else tells two blobs apart, so
/// that what is kept when there are too many does not depend on the order in which they were found.
bool before(const BlobMoments& a, const BlobMoments& b) noexcept;

/// Centroid and second central moments of the weights.
struct BlobShape {
  double x_px, y_px, var_xx_px2, var_xy_px2, var_yy_px2;
};
BlobShape shape_of(const BlobMoments& blob) noexcept;

/// All of a record. `undistorted`: of this shape, by undistort_blob().
BlobRecord to_record(const BlobMoments& blob, const BlobShape& shape, const Undistorted& undistorted,
                     std::uint32_t camera, const CameraFormat& format) noexcept;

}  // namespace glint::gpu
