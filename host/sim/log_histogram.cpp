// SPDX-License-Identifier: MIT
// Bins of equal width in the logarithm.
#include "host/sim/log_histogram.hpp"

#include <algorithm>
#include <cmath>

namespace glint::sim {

void LogHistogram::add(double value) noexcept {
  const double place = std::log10(std::max(value, kLowest) / kLowest) * static_cast<double>(kBinsPerDecade);
  // Not a number fails the comparison and counts as the largest.
  ++bins_[place < static_cast<double>(bins_.size()) ? static_cast<std::size_t>(place) : bins_.size() - 1];
  ++count_;
}

double LogHistogram::quantile(double q) const noexcept {
  if (count_ == 0) return 0.0;
  const auto rank = std::min(count_ - 1, static_cast<std::uint64_t>(q * static_cast<double>(count_)));
  std::uint64_t below = 0;
  std::size_t bin = 0;
  while (below + bins_[bin] <= rank) below += bins_[bin++];
  return kLowest * std::pow(10.0, (static_cast<double>(bin) + 0.5) / static_cast<double>(kBinsPerDecade));
}

}  // namespace glint::sim
