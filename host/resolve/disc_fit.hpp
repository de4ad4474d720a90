// SPDX-License-Identifier: MIT
// Discs fitted to pixels: for images of markers that touch, hide one another, are clipped or partly hidden.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include <Eigen/Core>
#include <Eigen/LU>

#include "gpu/detector.hpp"
#include "host/resolve/disc_profile.hpp"
#include "host/resolve/edge_overlap.hpp"
#include "host/resolve/pixel_noise.hpp"

namespace glint {

/// Part of an image, inclusive.
struct PixelBox {
  int x_min_px = 0, y_min_px = 0, x_max_px = -1, y_max_px = -1;
};

/// A marker that should be in the image.
struct ExpectedDisc {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< raw (distorted) image
  /// The marker's outline is { centre + v : v' shape^-1 v = 1 }.
  Eigen::Matrix2d shape_px2 = Eigen::Matrix2d::Identity();
  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();  ///< path over the exposure
  double grey = 0.0;                                    ///< level inside, above the dark; 0: unknown
  double grey_sd = 0.0;     ///< how well that is known; 0: only a guess to start from
  double distance_m = 0.0;  ///< the nearer disc hides the farther
  double centre_error_px =
      0.7;  ///< how far off the centre may be: at first no pixel is judged by more than that

  /// Of the round disc of the same area.
  double radius_px() const noexcept { return std::sqrt(std::sqrt(std::max(0.0, shape_px2.determinant()))); }
};

struct FittedDisc {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();  ///< raw image, at the middle of the exposure
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Zero();
  double grey = 0.0;  ///< level inside, above the background
};

/// How well the discs explain the pixels.
struct FitQuality {
  double background_grey = 0.0;
  double chi2_per_dof = 0.0;  ///< of the pixels that were believed; 1 if the noise is as given
  /// Likewise, apart for the pixels in which noise of the dark prevails and those in which that of light
  /// does; 0: there are none.
  double dark_chi2 = 0.0, lit_chi2 = 0.0;
  /// Share of the light that the discs should show in this box that was found; less where something unknown
  /// hides part of them or they reach beyond the image.
  double seen_share = 0.0;
  unsigned steps = 0;
};

inline constexpr std::size_t kMaxDiscs = 6;

/// Fits centres, brightnesses and one background to the pixels of a box by Gauss-Newton steps with analytic
/// derivatives, weighted by each pixel's noise and robustly (decision 0021). Thread-bound. Neither fit()
/// nor anything that it calls allocates.
class DiscFit {
 public:
  explicit DiscFit(const PixelNoise& noise);

  /// The expected centres are where the fit starts and nothing else: the result does not lean towards them.
  /// A known brightness counts as one more measurement. fitted[i] is expected[i]; both have at most
  /// kMaxDiscs. False: no convergence, or discs that these pixels cannot tell apart or do not show; `fitted`
  /// is then not to be used. The box may reach beyond the image.
  bool fit(const gpu::ImageView& image, const PixelBox& box, std::span<const ExpectedDisc> expected,
           std::span<FittedDisc> fitted, FitQuality& quality, const NoiseExcess& excess = {}) noexcept;

 private:
  PixelNoise noise_;
  DiscProfiles profiles_;
  EdgeOverlap overlap_;
};

}  // namespace glint
