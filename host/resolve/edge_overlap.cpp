// SPDX-License-Identifier: MIT
// The bivariate normal distribution, tabulated by its marginals.
#include "host/resolve/edge_overlap.hpp"

#include <array>
#include <numbers>

namespace glint {
namespace {

double normal_cdf(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// x with normal_cdf(x) = p, by bisection; only for making the table.
double normal_quantile(double p) {
  double low = -9.0, high = 9.0;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (normal_cdf(middle) < p ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

/// For one correlation sin(angle): the integral over the correlation's angle that takes independent normal X,
/// Y to correlated ones (Drezner and Wesolowsky, Journal of Statistical Computation and Simulation 35, 1990),
/// by Simpson's rule.
class CorrelationIntegral {
 public:
  explicit CorrelationIntegral(double angle) : step_(angle / (kNodes - 1)) {
    for (std::size_t n = 0; n < kNodes; ++n) {
      const double t = step_ * static_cast<double>(n), c = std::cos(t);
      sine_[n] = std::sin(t);
      scale_[n] = 0.5 / (c * c);
    }
  }
  /// P(X < h, Y < k) less P(X < h) P(Y < k).
  double operator()(double h, double k) const noexcept {
    double sum = 0.0;
    for (std::size_t n = 0; n < kNodes; ++n) {
      const double weight = n == 0 || n == kNodes - 1 ? 1.0 : (n % 2 == 1 ? 4.0 : 2.0);
      sum += weight * std::exp(-(h * h + k * k - 2.0 * h * k * sine_[n]) * scale_[n]);
    }
    return sum * step_ / (6.0 * std::numbers::pi);
  }

 private:
  static constexpr std::size_t kNodes = 65;
  double step_;
  std::array<double, kNodes> sine_, scale_;
};

}  // namespace

EdgeOverlap::EdgeOverlap() : shares_(kAngles * kLayer) {
  std::array<double, kShares> quantile{};
  for (std::size_t i = 1; i + 1 < kShares; ++i)
    quantile[i] = normal_quantile(static_cast<double>(i) / (kShares - 1));
  for (std::size_t a = 0; a < kAngles; ++a) {
    const double angle = std::numbers::pi * (0.5 - static_cast<double>(a) / (kAngles - 1));
    const CorrelationIntegral integral(angle);
    for (std::size_t i = 0; i < kShares; ++i) {
      for (std::size_t j = 0; j <= i; ++j) {
        const double p = static_cast<double>(i) / (kShares - 1), q = static_cast<double>(j) / (kShares - 1);
        double share = 0.0;
        if (i == 0 || j == 0 || i == kShares - 1 || j == kShares - 1 || a == 0) {
          share = std::min(p, q);
        } else if (a == kAngles - 1) {
          share = std::max(0.0, p + q - 1.0);
        } else {
          share = p * q + integral(quantile[i], quantile[j]);
        }
        shares_[(a * kShares + i) * kShares + j] = shares_[(a * kShares + j) * kShares + i] =
            static_cast<float>(share);
      }
    }
  }
}

}  // namespace glint
