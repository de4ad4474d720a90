// SPDX-License-Identifier: MIT
// Logarithmic bins and quantiles.
#include "host/output/latency_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace glint {

namespace {

constexpr double kSmallest = 1e-6;
constexpr int kDecades = 9, kBinsPerDecade = 200;
constexpr int kBins = kDecades * kBinsPerDecade;

int bin_of(double seconds) noexcept {
  if (seconds <= kSmallest) return 0;
  const double bin = std::floor(std::log10(seconds / kSmallest) * kBinsPerDecade);
  return static_cast<int>(std::clamp(bin, 0.0, static_cast<double>(kBins - 1)));
}

double middle_of(int bin) noexcept { return kSmallest * std::pow(10.0, (bin + 0.5) / kBinsPerDecade); }

}  // namespace

LatencyHistogram::LatencyHistogram() : bins_(kBins) {}

void LatencyHistogram::add(double seconds) noexcept {
  if (!(seconds >= 0.0) || !std::isfinite(seconds)) return;
  min_s_ = count_ == 0 ? seconds : std::min(min_s_, seconds);
  max_s_ = count_ == 0 ? seconds : std::max(max_s_, seconds);
  ++bins_[static_cast<std::size_t>(bin_of(seconds))];
  ++count_;
}

double LatencyHistogram::quantile_s(double fraction) const noexcept {
  if (count_ == 0) return 0.0;
  const double wanted = std::ceil(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(count_));
  const auto rank = std::max<std::uint64_t>(1, static_cast<std::uint64_t>(wanted));
  if (rank == count_) return max_s_;
  std::uint64_t seen = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    seen += bins_[static_cast<std::size_t>(bin)];
    if (seen >= rank) return std::clamp(middle_of(bin), min_s_, max_s_);
  }
  return max_s_;
}

std::uint64_t LatencyHistogram::count_between(double from_s, double to_s) const noexcept {
  std::uint64_t sum = 0;
  for (int bin = 0; bin < kBins; ++bin) {
    const double value = middle_of(bin);
    if (value >= from_s && value < to_s) sum += bins_[static_cast<std::size_t>(bin)];
  }
  return sum;
}

}  // namespace glint
