// SPDX-License-Identifier: MIT
// Significance limits and probabilities of the matcher, and where they come from.
#pragma once

#include <cmath>

namespace glint {

/// Chi-square limits at which a true blob is refused about once in 10,000: one degree of freedom (two rays
/// meet), two (a blob joins a point), three (a point fits a prediction).
inline constexpr double kPairChi2 = 15.1;
inline constexpr double kJoinChi2 = 18.4;
inline constexpr double kPredictionChi2 = 21.1;

/// Limit for the residuals of a whole point: once in 100,000, by Wilson and Hilferty's cube-root
/// approximation.
inline double point_chi2_limit(unsigned degrees_of_freedom) noexcept {
  const double d = degrees_of_freedom, a = 2.0 / (9.0 * d);
  return d * std::pow(1.0 - a + 4.265 * std::sqrt(a), 3);
}

/// How often a marker inside a camera's image gives a blob of its own: the rest is hidden or merged. Only its
/// logarithm counts, so that 0.8 or 0.95 decide hardly anything differently.
inline constexpr double kDetected = 0.9;

/// Share of the blobs that are of no marker. Only its logarithm counts, too.
inline constexpr double kClutterShare = 0.1;

/// A point that no third camera confirms and no track expected may be somewhat less likely than chance: the
/// tracker asks for several consistent frames before it shows it, which a chance meeting of rays does not
/// survive.
inline constexpr double kTwoViewLogOdds = -3.0;

}  // namespace glint
