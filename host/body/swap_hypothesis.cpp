// SPDX-License-Identifier: MIT
// Odds by innovations.
#include "host/body/swap_hypothesis.hpp"

#include <algorithm>
#include <cmath>

namespace glint {
namespace {

// No single frame decides more than this: a bounce, which no motion predicted, is not proof of anything.
constexpr double kMostPerFrame = 5.0;

double cost(const BodyMotion& motion, const Pose& measured, const Matrix6& covariance) noexcept {
  return gaussian_cost(pose_difference(measured, motion.pose()), motion.pose_covariance() + covariance);
}

}  // namespace

double log_odds_of_no_swap(const BodyMotion& motion_a, const Pose& measured_a, const Matrix6& covariance_a,
                           const BodyMotion& motion_b, const Pose& measured_b,
                           const Matrix6& covariance_b) noexcept {
  const double kept = cost(motion_a, measured_a, covariance_a) + cost(motion_b, measured_b, covariance_b);
  const double swapped = cost(motion_a, measured_b, covariance_b) + cost(motion_b, measured_a, covariance_a);
  const double odds = 0.5 * (swapped - kept);
  return std::isfinite(odds) ? odds : 0.0;
}

void SwapHypothesis::advance(double seconds, const BodyMotionOptions& options) noexcept {
  a_as_b_.advance(seconds, options);
  b_as_a_.advance(seconds, options);
}

void SwapHypothesis::weigh(const Pose& measured_a, const Matrix6& covariance_a, double cost_a,
                           const Pose& measured_b, const Matrix6& covariance_b, double cost_b) noexcept {
  const double swapped = cost(a_as_b_, measured_b, covariance_b) + cost(b_as_a_, measured_a, covariance_a);
  const double odds = 0.5 * (swapped - cost_a - cost_b);
  if (std::isfinite(odds)) log_odds_ += std::clamp(odds, -kMostPerFrame, kMostPerFrame);
  a_as_b_.correct(measured_b, covariance_b);
  b_as_a_.correct(measured_a, covariance_a);
}

}  // namespace glint
