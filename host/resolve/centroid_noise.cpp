// SPDX-License-Identifier: MIT
// Propagation of pixel noise, and floors that were measured.
#include "host/resolve/centroid_noise.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace glint {

Eigen::Matrix2d centroid_covariance_px2(const shaders::BlobRecord& blob, const PixelNoise& noise) noexcept {
  // What is above the limit ends in steps of a pixel. Measured over radii of 1 to 8 px and limits at 0.05 to
  // 0.6 of the disc's level: the error that this leaves grows with that share and falls as 1 / radius, and
  // goes up and down about that by a factor of up to two. A clipped top ends in steps, too.
  // Fewer pixels than four are hardly more than a place on the grid.
  constexpr double kGrid_px = 0.15, kFewPixels = 4.0;
  constexpr double kEdge_px2 = 0.13, kLeastEdge_px2 = 0.0035, kClippedEdge_px2 = 0.03;
  const double area = std::max(1.0, static_cast<double>(blob.area_px));
  const double weight = std::max(1.0, static_cast<double>(blob.weight));
  const double limit_grey = (static_cast<double>(blob.sum) - static_cast<double>(blob.weight)) / area;
  const double peak_grey = std::max(1.0, static_cast<double>(blob.peak) - limit_grey);
  const double above_dark = std::max(0.0, noise.limit_above_dark_grey);
  const double cut_share = above_dark / (above_dark + peak_grey);

  // The lower the limit, the farther out on the blurred edge it lies.
  const double outside_px =
      cut_share > 0.0 ? 0.68 * noise.blur_px() * std::max(0.0, std::log(0.45 / cut_share)) : 0.0;
  const double radius_px = std::max(0.5, std::sqrt(area / std::numbers::pi) - outside_px);
  double floor_px = (kEdge_px2 * cut_share + kLeastEdge_px2) / radius_px;
  if (area < kFewPixels) floor_px = std::hypot(floor_px, kGrid_px / area);
  if ((blob.flags & shaders::kBlobSaturated) != 0)
    floor_px = std::hypot(floor_px, kClippedEdge_px2 / radius_px);

  // x = sum w x / sum w, so its variance is the sum of var(w) (x - mean)^2 over (sum w)^2: photon noise
  // follows the weighted second moments, the rest those of the bare area, which has the same form.
  Eigen::Matrix2d moments;
  moments << static_cast<double>(blob.var_xx_px2), static_cast<double>(blob.var_xy_px2),
      static_cast<double>(blob.var_xy_px2), static_cast<double>(blob.var_yy_px2);
  // A blob of one pixel has none: it lies anywhere in its square.
  moments += 1.0 / 12.0 / area * Eigen::Matrix2d::Identity();
  const double mean_moment = 0.5 * moments.trace();
  const double bare = std::max(1.0, area / (4.0 * std::numbers::pi) / mean_moment);
  const double factor =
      (noise.grey_variance_per_grey * weight + noise.variance_grey2(above_dark) * area * bare) /
      (weight * weight);
  return factor * moments + floor_px * floor_px * Eigen::Matrix2d::Identity();
}

}  // namespace glint
