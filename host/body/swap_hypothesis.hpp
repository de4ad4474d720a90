// SPDX-License-Identifier: MIT
// Two bodies that look alike may have been exchanged: what speaks for it, as time goes on.
#pragma once

#include <cstdint>

#include "host/body/body_motion.hpp"

namespace glint {

/// Follows both bodies as they would have to have moved had they been exchanged, beside the motions that the
/// tracker believes in, and keeps the odds. Poses are of the bodies' common shape.
class SwapHypothesis {
 public:
  SwapHypothesis() = default;
  /// `motion_a`, `motion_b`: what the two were predicted to do before they came close or were found again.
  /// `log_odds`: log-likelihood by which they have not been exchanged.
  SwapHypothesis(const BodyMotion& motion_a, const BodyMotion& motion_b, double log_odds) noexcept
      : a_as_b_(motion_a), b_as_a_(motion_b), log_odds_(log_odds) {}

  void advance(double seconds, const BodyMotionOptions& options) noexcept;
  /// Both were measured; `cost_a`, `cost_b` are the gaussian_cost() of what was measured by what the tracker
  /// believed. Adds to the odds, and follows.
  void weigh(const Pose& measured_a, const Matrix6& covariance_a, double cost_a, const Pose& measured_b,
             const Matrix6& covariance_b, double cost_b) noexcept;
  /// > 0: more likely not exchanged.
  double log_odds() const noexcept { return log_odds_; }

 private:
  BodyMotion a_as_b_, b_as_a_;  // the motion of a that continues where b is, and of b where a is
  double log_odds_ = 0.0;
};

/// Log-likelihood by which two bodies were not exchanged: each motion predicts its own measurement against
/// that of the other.
double log_odds_of_no_swap(const BodyMotion& motion_a, const Pose& measured_a, const Matrix6& covariance_a,
                           const BodyMotion& motion_b, const Pose& measured_b,
                           const Matrix6& covariance_b) noexcept;

}  // namespace glint
