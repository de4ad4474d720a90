// SPDX-License-Identifier: MIT
// What is said about a series of samples: quantiles, and how sure the median is.
#pragma once

#include <cstddef>
#include <span>

namespace glint::bench {

struct Interval {
  double low = 0.0, high = 0.0;
};

/// In the unit of the samples.
struct Summary {
  std::size_t count = 0;
  double p50 = 0.0, p90 = 0.0, p99 = 0.0, max = 0.0;
  Interval median_95;  ///< 95 % bootstrap interval of the median
};

/// `fraction` in 0..1 of sorted samples, with linear interpolation between neighbours (definition 7 of
/// Hyndman and Fan 1996, which most software uses). 0 without samples.
double quantile(std::span<const double> sorted, double fraction);

/// 95 % interval of the median by the moving-block bootstrap (Kuensch 1989): stretches of neighbouring
/// samples are drawn together, because slow ticks come in groups. `samples` in the order in which they were
/// taken. The same samples always give the same interval.
Interval median_interval(std::span<const double> samples);

/// `samples` in the order in which they were taken.
Summary summarize(std::span<const double> samples);

}  // namespace glint::bench
