// SPDX-License-Identifier: MIT
// Quantiles and bootstrap.
#include "host/bench/statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace glint::bench {
namespace {

constexpr std::size_t kMostResamples = 1000, kFewestResamples = 200;
constexpr std::size_t kMostDraws = 20'000'000;  // of single samples; keeps very long runs from taking minutes

/// Splitmix64 (Steele, Lea, Flood 2014): the same numbers everywhere.
class Random {
 public:
  /// 0 .. below - 1; the bias of the remainder is under 2^-40 for fewer than 2^24 samples.
  std::size_t below(std::size_t limit) noexcept {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return static_cast<std::size_t>((z ^ z >> 31) % limit);
  }

 private:
  std::uint64_t state_ = 1;
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (*middle + *std::max_element(values.begin(), middle));
}

}  // namespace

double quantile(std::span<const double> sorted, double fraction) {
  if (sorted.empty()) return 0.0;
  const double at = std::clamp(fraction, 0.0, 1.0) * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, sorted.size() - 1);
  return sorted[below] + (at - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

Interval median_interval(std::span<const double> samples) {
  const std::size_t n = samples.size();
  if (n == 0) return {};
  const auto block = static_cast<std::size_t>(std::lround(std::sqrt(static_cast<double>(n))));
  const std::size_t resamples = std::clamp(kMostDraws / n, kFewestResamples, kMostResamples);
  Random random;
  std::vector<double> drawn(n), medians(resamples);
  for (double& result : medians) {
    for (std::size_t i = 0; i < n;) {
      const std::size_t from = random.below(n - block + 1), length = std::min(block, n - i);
      std::copy_n(samples.begin() + static_cast<std::ptrdiff_t>(from), length,
                  drawn.begin() + static_cast<std::ptrdiff_t>(i));
      i += length;
    }
    result = median(drawn);
  }
  std::sort(medians.begin(), medians.end());
  return {quantile(medians, 0.025), quantile(medians, 0.975)};
}

Summary summarize(std::span<const double> samples) {
  if (samples.empty()) return {};
  std::vector<double> sorted(samples.begin(), samples.end());
  std::sort(sorted.begin(), sorted.end());
  return {samples.size(),         quantile(sorted, 0.5), quantile(sorted, 0.9),
          quantile(sorted, 0.99), sorted.back(),         median_interval(samples)};
}

}  // namespace glint::bench
