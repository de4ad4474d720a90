// SPDX-License-Identifier: MIT
// Block bootstrap of a mean.
#include "host/sim/nees_band.hpp"

#include <algorithm>

#include "host/sim/random.hpp"

namespace glint::sim {

NeesBand::NeesBand(std::size_t markers, std::size_t blocks_of_each) : open_(markers) {
  blocks_.reserve(markers * blocks_of_each);
}

void NeesBand::add(std::uint32_t marker, std::uint64_t block, double normalised_squared_error) {
  Open& open = open_[marker];
  if (!open.any || open.block != block) {
    open = {block, blocks_.size(), true};
    blocks_.emplace_back();
  }
  Block& sum = blocks_[open.place];
  sum.sum += normalised_squared_error;
  ++sum.count;
}

NeesBand::Result NeesBand::result(std::uint32_t rounds, std::uint64_t seed) const {
  Result result;
  if (blocks_.empty()) return result;
  const auto mean_of = [&](auto&& next_block) {
    Block all;
    for (std::size_t i = 0; i < blocks_.size(); ++i) {
      const Block& block = blocks_[next_block(i)];
      all.sum += block.sum;
      all.count += block.count;
    }
    result.samples = all.count;
    return all.sum / static_cast<double>(all.count);
  };
  Random random(seed);
  std::vector<double> means(std::max<std::uint32_t>(rounds, 1));
  for (double& mean : means) {
    mean = mean_of([&](std::size_t) {
      return static_cast<std::size_t>(random.uniform() * static_cast<double>(blocks_.size()));
    });
  }
  std::sort(means.begin(), means.end());
  const auto quantile = [&](double q) {
    return means[static_cast<std::size_t>(q * static_cast<double>(means.size() - 1) + 0.5)];
  };
  result.low = quantile(0.025);
  result.high = quantile(0.975);
  result.mean = mean_of([](std::size_t i) { return i; });  // last, so that `samples` are those of the run
  return result;
}

}  // namespace glint::sim
