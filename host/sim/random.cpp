// SPDX-License-Identifier: MIT
// Table of normal quantiles.
#include "host/sim/random.hpp"

#include <cmath>
#include <numbers>

namespace glint::sim {
namespace {

/// Inverse of the normal distribution's upper half by Newton's method; p in (0.5, 1).
double quantile(double p, double start) {
  double x = start;
  for (int i = 0; i < 60; ++i) {
    const double excess = 0.5 * std::erfc(-x / std::numbers::sqrt2) - p;
    const double density = std::exp(-0.5 * x * x) / std::sqrt(2.0 * std::numbers::pi);
    const double step = excess / density;
    x -= step;
    if (std::abs(step) < 1e-12) break;
  }
  return x;
}

}  // namespace

NormalTable::NormalTable() {
  constexpr std::size_t kHalf = 2048;
  std::array<double, kHalf> upper{};
  double sum_squares = 0.0, x = 0.0;
  for (std::size_t i = 0; i < kHalf; ++i) {
    x = quantile(0.5 + (static_cast<double>(i) + 0.5) / 4096.0, x);  // each starts where the last one ended
    upper[i] = x;
    sum_squares += x * x;
  }
  const double scale =
      1.0 / std::sqrt(sum_squares / kHalf);  // midpoints of equal slices lose a little variance
  for (std::size_t i = 0; i < kHalf; ++i) {
    const auto value = static_cast<float>(std::round(upper[i] * scale * 4096.0) / 4096.0);
    values_[kHalf + i] = value;
    values_[kHalf - 1 - i] = -value;
  }
}

}  // namespace glint::sim
