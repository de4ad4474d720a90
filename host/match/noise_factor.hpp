// SPDX-License-Identifier: MIT
// By how much centroids err more, or less, than their pixels let expect.
#pragma once

#include <algorithm>

namespace glint {

/// The ratio of the variance that residuals show to the variance that was expected of them: the a-posteriori
/// variance factor of adjustment theory (Koch, Parameter Estimation and Hypothesis Testing in Linear Models,
/// 1999, 3.2.5), here over what was seen of late.
class NoiseFactor {
 public:
  /// A residual of one view. misfit: its squared length over the blob's expected variance per axis. freedom:
  /// what that would be on average if the expected variance were the true one, 2 less what the view itself
  /// decided of the position.
  void learn(double misfit, double freedom) noexcept {
    // A view that decides the position all but alone shows no residual, and some are not what they were taken
    // for: a true residual is as large once in 3,000.
    if (!(freedom > kLeastFreedom) || !(misfit <= kLargest * factor_ * freedom)) return;
    weight_ = std::min(weight_ + freedom, kLongest);
    factor_ += (misfit / freedom - factor_) * freedom / weight_;
    factor_ = std::clamp(factor_, kLeast, kMost);
  }
  double value() const noexcept { return factor_; }

 private:
  static constexpr double kLeastFreedom = 0.2, kLargest = 8.0, kLeast = 0.2, kMost = 4.0;
  // What was assumed counts as much as so many residuals, and nothing is remembered longer than so many.
  static constexpr double kAssumed = 100.0, kLongest = 5000.0;

  double factor_ = 1.0, weight_ = kAssumed;
};

}  // namespace glint
