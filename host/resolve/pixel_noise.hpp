// SPDX-License-Identifier: MIT
// How much a pixel can be believed.
#pragma once

#include <cmath>

namespace glint {

/// Optics and sensor, as far as fits to pixels depend on them. The defaults are those of a raw 8-bit camera
/// with a small lens in focus.
struct PixelNoise {
  double psf_sigma_px = 0.6;  ///< optical blur, Gaussian, before a pixel integrates over its square
  /// Standard deviation of a dark pixel before it is rounded. Between pixels: the fixed pattern that a frame
  /// shows is noise to whoever looks at one frame.
  double read_noise_grey = 0.7;
  double grey_variance_per_grey = 0.04;  ///< photon noise: variance for each grey level of light
  double limit_above_dark_grey = 12.0;   ///< how far the detector's limit lies above a dark pixel's mean

  /// Of the optics and of the pixel's square, which counts as a Gaussian of the same variance.
  double blur_px() const noexcept { return std::sqrt(psf_sigma_px * psf_sigma_px + 1.0 / 12.0); }
  /// Variance of a pixel, rounding included, for that much light above the dark.
  double variance_grey2(double light_grey) const noexcept {
    return read_noise_grey * read_noise_grey + 1.0 / 12.0 +
           grey_variance_per_grey * (light_grey > 0.0 ? light_grey : 0.0);
  }
};

}  // namespace glint
