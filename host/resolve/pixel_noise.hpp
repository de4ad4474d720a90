// SPDX-License-Identifier: MIT
// How much a pixel can be believed.
#pragma once

#include <algorithm>
#include <cmath>

namespace glint {

/// Variance of one camera's pixels over what PixelNoise says: over time without light, and what light adds to
/// it.
struct NoiseExcess {
  double dark = 1.0, light = 1.0;
};

/// Optics and sensor, as far as fits to pixels depend on them. The defaults are those of a raw 8-bit camera
/// with a small lens in focus.
struct PixelNoise {
  double psf_sigma_px = 0.6;         ///< optical blur, Gaussian, before a pixel integrates over its square
  double read_noise_grey = 0.25;     ///< standard deviation of a dark pixel over time, before it is rounded
  double fixed_pattern_grey = 0.65;  ///< that of what it shows in the mean, between the pixels
  double grey_variance_per_grey = 0.04;  ///< photon noise: variance for each grey level of light
  double limit_above_dark_grey = 12.0;   ///< how far the detector's limit lies above a dark pixel's mean

  /// Of the optics and of the pixel's square, which counts as a Gaussian of the same variance.
  double blur_px() const noexcept { return std::sqrt(psf_sigma_px * psf_sigma_px + 1.0 / 12.0); }
  /// Variance over time of a pixel, rounding included, for that much light above the dark.
  double variance_over_time_grey2(double light_grey) const noexcept {
    return read_noise_grey * read_noise_grey + 1.0 / 12.0 +
           grey_variance_per_grey * (light_grey > 0.0 ? light_grey : 0.0);
  }
  /// The same where it is not known what the pixel shows in the dark: the pattern is noise, too.
  double variance_grey2(double light_grey) const noexcept {
    return variance_over_time_grey2(light_grey) + fixed_pattern_grey * fixed_pattern_grey;
  }
  /// That of a camera with so much more of it.
  PixelNoise with(const NoiseExcess& excess) const noexcept {
    PixelNoise noise = *this;
    noise.read_noise_grey =
        std::sqrt(std::max(0.0, excess.dark * variance_over_time_grey2(0.0) - 1.0 / 12.0));
    noise.grey_variance_per_grey *= excess.light;
    return noise;
  }
};

}  // namespace glint
