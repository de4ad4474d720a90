// SPDX-License-Identifier: MIT
// Are covariances honest? The mean normalised squared error and how well it is known.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace glint::sim {

/// Errors of one marker are correlated in time (it stays half hidden, between the same two cameras, in motion
/// blur), so the mean over all is known less well than its number of samples says. The band comes from
/// drawing whole blocks, each a marker over a stretch of time, with replacement (block bootstrap: Kunsch,
/// Annals of Statistics 17, 1989; here non-overlapping).
class NeesBand {
 public:
  struct Result {
    double mean = 0.0, low = 0.0, high = 0.0;  ///< 0 without samples
    std::uint64_t samples = 0;
  };

  NeesBand(std::size_t markers, std::size_t blocks_of_each);

  /// `block` numbers stretches of time, ascending for each marker.
  void add(std::uint32_t marker, std::uint64_t block, double normalised_squared_error);
  /// 2.5 % and 97.5 % quantiles of the mean over `rounds` draws.
  Result result(std::uint32_t rounds, std::uint64_t seed) const;

 private:
  struct Block {
    double sum = 0.0;
    std::uint64_t count = 0;
  };
  struct Open {
    std::uint64_t block = 0;
    std::size_t place = 0;  // in blocks_
    bool any = false;
  };
  std::vector<Block> blocks_;
  std::vector<Open> open_;  // per marker
};

}  // namespace glint::sim
