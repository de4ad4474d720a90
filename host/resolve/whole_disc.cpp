// SPDX-License-Identifier: MIT
// The moments that a disc should have above the limit, compared with those of a blob.
#include "host/resolve/whole_disc.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <Eigen/LU>

#include "host/resolve/centroid_noise.hpp"

namespace glint {

WholeDiscTest::WholeDiscTest(const PixelNoise& noise)
    : noise_(noise), sigma_px_(noise.blur_px()), cut_discs_(DiscProfiles(noise.psf_sigma_px)) {}

// The brightest of many pixels is brighter than they are on average, and the blur takes some of the light of
// a small disc even from its middle.
double WholeDiscTest::grey_of(const shaders::BlobRecord& blob, double radius_px) const noexcept {
  const double area = std::max(1.0, static_cast<double>(blob.area_px));
  const double limit_grey = (static_cast<double>(blob.sum) - static_cast<double>(blob.weight)) / area;
  const double peak = static_cast<double>(blob.peak) - limit_grey + noise_.limit_above_dark_grey;
  const double many = std::sqrt(2.0 * std::log(std::max(1.0, 0.5 * area)));
  const double in_middle = 1.0 - std::exp(-0.5 * radius_px * radius_px / (sigma_px_ * sigma_px_));
  return (peak - many * std::sqrt(noise_.variance_grey2(peak))) / std::max(0.1, in_middle);
}

double WholeDiscTest::grey(const shaders::BlobRecord& blob, const ExpectedDisc& expected) const noexcept {
  return grey_of(blob, expected.radius_px());
}

double WholeDiscTest::radius_px(const shaders::BlobRecord& blob, double second_moment_px2) const noexcept {
  double low = 0.0, high = 4.0 * std::sqrt(std::max(0.0, second_moment_px2)) + 1.0;  // of a bare disc: 2
  for (int i = 0; i < 20; ++i) {
    const double radius = 0.5 * (low + high), grey = grey_of(blob, radius);
    const double moment =
        grey > 0.0 ? cut_discs_.of(radius, noise_.limit_above_dark_grey / grey).second_moment_px2 : 0.0;
    (moment < second_moment_px2 ? low : high) = radius;
  }
  return 0.5 * (low + high);
}

BlobDeviation WholeDiscTest::deviation(const shaders::BlobRecord& blob,
                                       const ExpectedDisc& expected) const noexcept {
  const double variance = sigma_px_ * sigma_px_;
  const Eigen::Matrix2d moments = 0.25 * expected.shape_px2 + variance * Eigen::Matrix2d::Identity() +
                                  expected.motion_px * expected.motion_px.transpose() / 12.0;
  const double scale = std::sqrt(std::max(moments.determinant(), variance * variance));
  const double radius = 2.0 * std::sqrt(scale - variance);
  const double limit = noise_.limit_above_dark_grey, area = static_cast<double>(blob.area_px);
  const double weight = static_cast<double>(blob.weight);
  const double grey = expected.grey > 0.0 ? expected.grey : grey_of(blob, radius);
  const CutDisc want = grey > 0.0 ? cut_discs_.of(radius, limit / grey) : CutDisc{};
  if (!(want.second_moment_px2 > 0.0)) return {area, weight, 0.0, 0.0};  // should not be seen at all

  Eigen::Matrix2d found;
  found << static_cast<double>(blob.var_xx_px2), static_cast<double>(blob.var_xy_px2),
      static_cast<double>(blob.var_xy_px2), static_cast<double>(blob.var_yy_px2);
  // In the metric in which the expected disc is round; the trace and determinant of this product are those.
  const Eigen::Matrix2d relative = found * moments.inverse() * (scale / want.second_moment_px2);
  const double mean = 0.5 * relative.trace();
  const double half_difference = std::sqrt(std::max(0.0, mean * mean - relative.determinant()));
  return {area / want.area_px2 - 1.0, weight / (grey * want.light_px2) - 1.0, mean - 1.0,
          half_difference / std::max(mean, 1e-9)};
}

bool WholeDiscTest::may_be_whole(const shaders::BlobRecord& blob, const ExpectedDisc& expected,
                                 const NoiseExcess& excess) const noexcept {
  // How much whole discs deviate by noise and by where they lie on the pixel grid goes with the error of
  // their centroids; the constants are what expected radius (1 %), roundness and brightness may be wrong by.
  // A high limit makes all of it larger.
  constexpr double kSigmas = 6.0, kShape = 0.03, kSize = 0.06, kWeight = 0.06, kArea = 0.06;
  constexpr double kAreaGrid_px = 0.45;    // of the radius that the area stands for
  constexpr std::uint32_t kFewPixels = 8;  // have no shape
  if ((blob.flags & (shaders::kBlobSaturated | shaders::kBlobOnBorder)) != 0) return false;
  const double radius_px = expected.radius_px();
  if (!(radius_px > 0.0) || blob.area_px == 0) return false;
  const BlobDeviation off = deviation(blob, expected);
  const double limit_grey = (static_cast<double>(blob.sum) - static_cast<double>(blob.weight)) / blob.area_px;
  const double high = 1.0 + noise_.limit_above_dark_grey / std::max(1.0, blob.peak - limit_grey);
  // Errors of compression hang together over several pixels: a blob's shape suffers as if all its light did.
  const double most = std::max(excess.dark, excess.light);
  const double noise =
      kSigmas * std::sqrt(0.5 * centroid_covariance_px2(blob, noise_.with({most, most})).trace()) / radius_px;
  if (blob.area_px >= kFewPixels &&
      (off.shape > kShape * high + noise || std::abs(off.size) > kSize * high + noise))
    return false;
  if (std::abs(off.area) > (kArea + kAreaGrid_px / radius_px) * high + noise) return false;
  if (!(expected.grey > 0.0)) return true;
  return std::abs(off.weight) <= (kWeight + kSigmas * expected.grey_sd / expected.grey) * high + noise;
}

}  // namespace glint
