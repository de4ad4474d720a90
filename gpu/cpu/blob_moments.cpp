// SPDX-License-Identifier: MIT
// From integer sums to a BlobRecord.
#include "gpu/cpu/blob_moments.hpp"

#include <algorithm>
#include <tuple>

#include "gpu/lens.hpp"

namespace glint::gpu {

void BlobMoments::merge(const BlobMoments& other) noexcept {
  area += other.area;
  peak = std::max(peak, other.peak);
  x_min = std::min(x_min, other.x_min);
  y_min = std::min(y_min, other.y_min);
  x_max = std::max(x_max, other.x_max);
  y_max = std::max(y_max, other.y_max);
  sum += other.sum;
  w += other.w;
  wx += other.wx;
  wy += other.wy;
  wxx += other.wxx;
  wxy += other.wxy;
  wyy += other.wyy;
}

bool before(const BlobMoments& a, const BlobMoments& b) noexcept {
  const auto key = [](const BlobMoments& m) {
    return std::tie(m.y_min, m.x_min, m.area, m.sum, m.y_max, m.x_max, m.w, m.peak, m.wx, m.wy);
  };
  return key(a) < key(b);
}

BlobRecord to_record(const BlobMoments& blob, std::uint32_t camera, const CameraFormat& format) noexcept {
  BlobRecord record{};
  record.camera = camera;
  record.area_px = blob.area;
  record.sum = static_cast<std::uint32_t>(blob.sum);
  record.weight = static_cast<std::uint32_t>(blob.w);
  record.peak = blob.peak;
  record.x_min_px = blob.x_min;
  record.y_min_px = blob.y_min;
  record.x_max_px = blob.x_max;
  record.y_max_px = blob.y_max;
  // Moments about the corner of the bounding box: still exact integers (arithmetic modulo 2^64, and the
  // results fit), and small, so that nothing is left to cancel in floating point.
  const std::uint64_t x0 = blob.x_min, y0 = blob.y_min;
  const std::uint64_t rx = blob.wx - x0 * blob.w, ry = blob.wy - y0 * blob.w;
  const std::uint64_t rxx = blob.wxx - 2 * x0 * blob.wx + x0 * x0 * blob.w;
  const std::uint64_t rxy = blob.wxy - x0 * blob.wy - y0 * blob.wx + x0 * y0 * blob.w;
  const std::uint64_t ryy = blob.wyy - 2 * y0 * blob.wy + y0 * y0 * blob.w;
  const double weight = static_cast<double>(blob.w);
  const double mean_x = static_cast<double>(rx) / weight, mean_y = static_cast<double>(ry) / weight;
  const double var_xx = std::max(0.0, static_cast<double>(rxx) / weight - mean_x * mean_x);
  const double var_xy = static_cast<double>(rxy) / weight - mean_x * mean_y;
  const double var_yy = std::max(0.0, static_cast<double>(ryy) / weight - mean_y * mean_y);
  const double x = static_cast<double>(x0) + mean_x, y = static_cast<double>(y0) + mean_y;
  const Undistorted u = undistort_blob(format.lens, x, y, var_xx, var_xy, var_yy);
  record.x_px = static_cast<float>(x);
  record.y_px = static_cast<float>(y);
  record.x_undist = static_cast<float>(u.x);
  record.y_undist = static_cast<float>(u.y);
  record.var_xx_px2 = static_cast<float>(var_xx);
  record.var_xy_px2 = static_cast<float>(var_xy);
  record.var_yy_px2 = static_cast<float>(var_yy);
  if (!u.converged) record.flags |= shaders::kBlobNotInvertible;
  if (blob.peak == 255) record.flags |= shaders::kBlobSaturated;
  if (blob.x_min == 0 || blob.y_min == 0 || blob.x_max + 1 == format.width_px ||
      blob.y_max + 1 == format.height_px) {
    record.flags |= shaders::kBlobOnBorder;
  }
  return record;
}

}  // namespace glint::gpu
