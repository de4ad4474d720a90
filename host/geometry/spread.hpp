// SPDX-License-Identifier: MIT
// How wide a normal distribution in the image is along its longest axis.
#pragma once

#include <cmath>

#include <Eigen/Core>

namespace glint {

/// Largest eigenvalue of a symmetric matrix: the variance along the longest axis of its ellipse.
inline double largest_variance(const Eigen::Matrix2d& covariance) noexcept {
  const double mean = 0.5 * (covariance(0, 0) + covariance(1, 1));
  return mean + std::hypot(0.5 * (covariance(0, 0) - covariance(1, 1)), covariance(0, 1));
}

/// Standard deviation along the longest axis.
inline double largest_sigma(const Eigen::Matrix2d& covariance) noexcept {
  return std::sqrt(largest_variance(covariance));
}

}  // namespace glint
