// SPDX-License-Identifier: MIT
// The moments that a disc should have above the limit, compared with those of a blob.
#include "host/resolve/whole_disc.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>

#include <Eigen/LU>

#include "host/resolve/centroid_noise.hpp"

namespace glint {

WholeDiscTest::WholeDiscTest(const PixelNoise& noise) : noise_(noise), profiles_(noise.psf_sigma_px) {}

BlobDeviation WholeDiscTest::deviation(const shaders::BlobRecord& blob,
                                       const ExpectedDisc& expected) const noexcept {
  const double variance = profiles_.sigma_px() * profiles_.sigma_px();
  const Eigen::Matrix2d moments = 0.25 * expected.shape_px2 + variance * Eigen::Matrix2d::Identity() +
                                  expected.motion_px * expected.motion_px.transpose() / 12.0;
  const double scale = std::sqrt(std::max(moments.determinant(), variance * variance));
  const double radius = 2.0 * std::sqrt(scale - variance);
  const DiscProfile profile = profiles_.of(radius);
  const double limit = noise_.limit_above_dark_grey, area = static_cast<double>(blob.area_px);
  const double weight = static_cast<double>(blob.weight);
  double grey = expected.grey;
  if (!(grey > 0.0)) {
    const double limit_grey = (static_cast<double>(blob.sum) - weight) / std::max(1.0, area);
    const double peak = static_cast<double>(blob.peak) - limit_grey + limit;
    // The brightest of many pixels is brighter than they are on average.
    const double many = std::sqrt(2.0 * std::log(std::max(1.0, 0.5 * area)));
    grey = (peak - many * std::sqrt(noise_.variance_grey2(peak))) /
           std::max(0.1, static_cast<double>(profile.at(0.0f).share));
  }

  // Over rings out to where the profile falls below the limit.
  constexpr int kRings = 48;
  const double step = static_cast<double>(profile.reach_px()) / kRings;
  double want_area = 0.0, want_weight = 0.0, want_second = 0.0, inner = 0.0;
  double above_inner = grey * static_cast<double>(profile.at(0.0f).share) - limit;
  for (int i = 1; i <= kRings && above_inner > 0.0; ++i) {
    double outer = step * i;
    double above = grey * static_cast<double>(profile.at(static_cast<float>(outer)).share) - limit;
    if (above < 0.0) {
      outer = inner + (outer - inner) * above_inner / (above_inner - above);
      above = 0.0;
    }
    const double middle = 0.5 * (inner + outer), ring = 2.0 * std::numbers::pi * middle * (outer - inner);
    const double light = 0.5 * (above_inner + above) * ring;
    want_area += ring;
    want_weight += light;
    want_second += light * (middle * middle + (outer - inner) * (outer - inner) / 12.0);
    inner = outer, above_inner = above;
  }
  if (!(want_weight > 0.0)) return {area, weight, 0.0, 0.0};  // should not be seen at all
  const double want_moment = 0.5 * want_second / want_weight;

  Eigen::Matrix2d found;
  found << static_cast<double>(blob.var_xx_px2), static_cast<double>(blob.var_xy_px2),
      static_cast<double>(blob.var_xy_px2), static_cast<double>(blob.var_yy_px2);
  // In the metric in which the expected disc is round; the trace and determinant of this product are those.
  const Eigen::Matrix2d relative = found * moments.inverse() * (scale / want_moment);
  const double mean = 0.5 * relative.trace();
  const double half_difference = std::sqrt(std::max(0.0, mean * mean - relative.determinant()));
  return {area / want_area - 1.0, weight / want_weight - 1.0, mean - 1.0,
          half_difference / std::max(mean, 1e-9)};
}

bool WholeDiscTest::may_be_whole(const shaders::BlobRecord& blob,
                                 const ExpectedDisc& expected) const noexcept {
  // How much whole discs deviate by noise and by where they lie on the pixel grid goes with the error of
  // their centroids; the constants are what expected radius (1 %), roundness and brightness may be wrong by.
  // A high limit makes all of it larger.
  constexpr double kSigmas = 6.0, kShape = 0.03, kSize = 0.06, kWeight = 0.06, kArea = 0.06;
  constexpr double kAreaGrid_px = 0.45;    // of the radius that the area stands for
  constexpr std::uint32_t kFewPixels = 8;  // have no shape
  if ((blob.flags & (shaders::kBlobSaturated | shaders::kBlobOnBorder)) != 0) return false;
  const double radius_px = std::sqrt(std::sqrt(std::max(0.0, expected.shape_px2.determinant())));
  if (!(radius_px > 0.0) || blob.area_px == 0) return false;
  const BlobDeviation off = deviation(blob, expected);
  const double limit_grey = (static_cast<double>(blob.sum) - static_cast<double>(blob.weight)) / blob.area_px;
  const double high = 1.0 + noise_.limit_above_dark_grey / std::max(1.0, blob.peak - limit_grey);
  const double noise = kSigmas * std::sqrt(0.5 * centroid_covariance_px2(blob, noise_).trace()) / radius_px;
  if (blob.area_px >= kFewPixels &&
      (off.shape > kShape * high + noise || std::abs(off.size) > kSize * high + noise))
    return false;
  if (std::abs(off.area) > (kArea + kAreaGrid_px / radius_px) * high + noise) return false;
  if (!(expected.grey > 0.0)) return true;
  return std::abs(off.weight) <= (kWeight + kSigmas * expected.grey_sd / expected.grey) * high + noise;
}

}  // namespace glint
