// SPDX-License-Identifier: MIT
// From integer sums to a BlobRecord.
#include "gpu/cpu/blob_moments.hpp"

#include <tuple>

namespace glint::gpu {

bool before(const BlobMoments& a, const BlobMoments& b) noexcept {
  const auto key = [](const BlobMoments& m) {
    return std::tie(m.y_min, m.x_min, m.area, m.sum, m.y_max, m.x_max, m.w, m.peak, m.wx, m.wy);
  };
  return key(a) < key(b);
}

BlobShape shape_of(const BlobMoments& blob) noexcept {
  // Moments about the corner of the bounding box: still exact integers (arithmetic modulo 2^64, and the
  // results fit), and small, so that nothing is left to cancel in floating point.
  const std::uint64_t x0 = blob.x_min, y0 = blob.y_min;
  const std::uint64_t rx = blob.wx - x0 * blob.w, ry = blob.wy - y0 * blob.w;
  const std::uint64_t rxx = blob.wxx - 2 * x0 * blob.wx + x0 * x0 * blob.w;
  const std::uint64_t rxy = blob.wxy - x0 * blob.wy - y0 * blob.wx + x0 * y0 * blob.w;
  const std::uint64_t ryy = blob.wyy - 2 * y0 * blob.wy + y0 * y0 * blob.w;
  const double weight = static_cast<double>(blob.w);
  const double mean_x = static_cast<double>(rx) / weight, mean_y = static_cast<double>(ry) / weight;
  return {static_cast<double>(x0) + mean_x, static_cast<double>(y0) + mean_y,
          std::max(0.0, static_cast<double>(rxx) / weight - mean_x * mean_x),
          static_cast<double>(rxy) / weight - mean_x * mean_y,
          std::max(0.0, static_cast<double>(ryy) / weight - mean_y * mean_y)};
}

BlobRecord to_record(const BlobMoments& blob, const BlobShape& shape, const Undistorted& undistorted,
                     std::uint32_t camera, const CameraFormat& format) noexcept {
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
  record.x_px = static_cast<float>(shape.x_px);
  record.y_px = static_cast<float>(shape.y_px);
  record.x_undist = static_cast<float>(undistorted.x);
  record.y_undist = static_cast<float>(undistorted.y);
  record.var_xx_px2 = static_cast<float>(shape.var_xx_px2);
  record.var_xy_px2 = static_cast<float>(shape.var_xy_px2);
  record.var_yy_px2 = static_cast<float>(shape.var_yy_px2);
  if (!undistorted.converged) record.flags |= shaders::kBlobNotInvertible;
  if (blob.peak == 255) record.flags |= shaders::kBlobSaturated;
  if (blob.x_min == 0 || blob.y_min == 0 || blob.x_max + 1 == format.width_px ||
      blob.y_max + 1 == format.height_px) {
    record.flags |= shaders::kBlobOnBorder;
  }
  return record;
}

}  // namespace glint::gpu
