// SPDX-License-Identifier: MIT
// Blurred discs, integrated along the radius.
#include "host/resolve/disc_profile.hpp"

#include <algorithm>
#include <cmath>

namespace glint {
namespace {

// Radii of the rows, in sigma. A disc below the first is a point to any camera; above the last the curvature
// of the edge no longer matters.
constexpr double kRowStep = 0.125, kFirstRow = 0.25;
constexpr std::size_t kRows = 400;

/// exp(-x) I1(x), to 1e-7 (Abramowitz and Stegun, Handbook of Mathematical Functions, 9.8.3 and 9.8.4).
double scaled_bessel_i1(double x) noexcept {
  if (x < 3.75) {
    const double t = (x / 3.75) * (x / 3.75);
    return std::exp(-x) * x *
           (0.5 +
            t * (0.87890594 +
                 t * (0.51498869 + t * (0.15084934 + t * (0.02658733 + t * (0.00301532 + t * 0.00032411))))));
  }
  const double t = 3.75 / x;
  return (0.39894228 +
          t * (-0.03988024 +
               t * (-0.00362018 +
                    t * (0.00163801 +
                         t * (-0.01031555 +
                              t * (0.02282967 + t * (-0.02895312 + t * (0.01787654 - t * 0.00420059)))))))) /
         std::sqrt(x);
}

/// Derivative by r of a disc of radius R through a Gaussian, all in units of its sigma: the blurred disc is
/// the integral of rho exp(-(rho^2 + r^2) / 2) I0(rho r) up to R, whose derivative by r has this closed form.
double slope(double radius, double r) noexcept {
  return -radius * std::exp(-0.5 * (radius - r) * (radius - r)) * scaled_bessel_i1(radius * r);
}

}  // namespace

DiscProfiles::DiscProfiles(double psf_sigma_px)
    : sigma_px_(std::sqrt(psf_sigma_px * psf_sigma_px + 1.0 / 12.0)), rows_(kRows) {
  constexpr double kStep = 1.0 / DiscProfile::kSteps_per_sigma, kFarInside = 7.0;
  for (std::size_t n = 0; n < kRows; ++n) {
    const double radius = kFirstRow + kRowStep * static_cast<double>(n);
    double r = std::max(0.0, radius - kFarInside);
    double share = r > 0.0 ? 1.0 : 1.0 - std::exp(-0.5 * radius * radius);
    for (std::size_t i = 0; i < DiscProfile::kNodes; ++i) {
      const double node = std::max(0.0, radius - DiscProfile::kReach_sigma + kStep * static_cast<double>(i));
      // Simpson's rule from the node before.
      const int pieces = std::max(1, static_cast<int>(std::ceil((node - r) / kStep)));
      const double width = (node - r) / pieces;
      for (int k = 0; k < pieces; ++k, r += width)
        share += width / 6.0 *
                 (slope(radius, r) + 4.0 * slope(radius, r + 0.5 * width) + slope(radius, r + width));
      r = node;
      rows_[n].share[i] = static_cast<float>(share);
      rows_[n].slope[i] = static_cast<float>(slope(radius, node));
    }
  }
}

DiscProfile DiscProfiles::of(double radius_px) const noexcept {
  DiscProfile profile;
  const double radius = radius_px / sigma_px_;
  const double row = std::clamp((radius - kFirstRow) / kRowStep, 0.0, static_cast<double>(kRows) - 1.001);
  const auto n = static_cast<std::size_t>(row);
  const auto far = static_cast<float>(row - static_cast<double>(n));
  const Row &low = rows_[n], &high = rows_[n + 1];
  for (std::size_t i = 0; i < DiscProfile::kNodes; ++i) {
    profile.share_[i] = low.share[i] + far * (high.share[i] - low.share[i]);
    // Towards the centre the slope falls in proportion to r.
    const double r = std::max(
        radius - DiscProfile::kReach_sigma + static_cast<double>(i) / DiscProfile::kSteps_per_sigma, 0.05);
    profile.slope_over_r_[i] = (low.slope[i] + far * (high.slope[i] - low.slope[i])) *
                               static_cast<float>(1.0 / (r * sigma_px_ * sigma_px_));
  }
  profile.first_px_ = static_cast<float>(radius_px - DiscProfile::kReach_sigma * sigma_px_);
  profile.nodes_per_px_ = static_cast<float>(DiscProfile::kSteps_per_sigma / sigma_px_);
  profile.reach_px_ = static_cast<float>(radius_px + DiscProfile::kReach_sigma * sigma_px_);
  profile.inner_ = profile.share_[0];
  return profile;
}

}  // namespace glint
