// SPDX-License-Identifier: MIT
// The bivariate normal distribution, tabulated by its marginals.
#include "host/resolve/edge_overlap.hpp"

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

/// P(X < h, Y < k) for standard normal X, Y with correlation sin(angle): p q plus an integral over the
/// correlation's angle (Drezner and Wesolowsky, Journal of Statistical Computation and Simulation 35, 1990).
double bivariate_cdf(double h, double k, double angle) {
  constexpr int kPieces = 64;
  const auto integrand = [h, k](double t) {
    const double c = std::cos(t);
    return std::exp(-(h * h + k * k - 2.0 * h * k * std::sin(t)) / (2.0 * c * c));
  };
  const double width = angle / kPieces;
  double sum = 0.0;
  for (int i = 0; i < kPieces; ++i)
    sum += width / 6.0 *
           (integrand(i * width) + 4.0 * integrand((i + 0.5) * width) + integrand((i + 1.0) * width));
  return normal_cdf(h) * normal_cdf(k) + sum / (2.0 * std::numbers::pi);
}

}  // namespace

EdgeOverlap::EdgeOverlap() : shares_(kAngles * kLayer) {
  for (std::size_t a = 0; a < kAngles; ++a) {
    const double angle = std::numbers::pi * (0.5 - static_cast<double>(a) / (kAngles - 1));
    for (std::size_t i = 0; i < kShares; ++i) {
      for (std::size_t j = 0; j < kShares; ++j) {
        const double p = static_cast<double>(i) / (kShares - 1), q = static_cast<double>(j) / (kShares - 1);
        double share = 0.0;
        if (i == 0 || j == 0 || i == kShares - 1 || j == kShares - 1 || a == 0) {
          share = std::min(p, q);
        } else if (a == kAngles - 1) {
          share = std::max(0.0, p + q - 1.0);
        } else {
          share = bivariate_cdf(normal_quantile(p), normal_quantile(q), angle);
        }
        shares_[(a * kShares + i) * kShares + j] = static_cast<float>(share);
      }
    }
  }
}

}  // namespace glint
