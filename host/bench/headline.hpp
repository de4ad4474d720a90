// SPDX-License-Identifier: MIT
// The one number for a buyer: how many cameras does this device keep up with?
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "host/bench/check.hpp"
#include "host/bench/results.hpp"
#include "host/bench/targets.hpp"

namespace glint::bench {

/// How a number of cameras went at a rate.
struct Attempt {
  bool in_time = false;
  double p99_s = 0.0;
  Outcome outcome = Outcome::Ok;
  std::string problem;
};

/// Largest number of cameras in 1..`most` that is in time, by bisection, taking for granted that more cameras
/// are slower. An attempt that is not Ok ends the search: Wrong at once; Failed counts as too many cameras,
/// and as a failure only if one camera fails; `problem` tells it where it, and not time, set the limit.
/// `attempt` is called with 1..`most`.
Headline search_headline(double rate_hz, unsigned most, const std::function<Attempt(unsigned)>& attempt);

/// For each rate the most cameras of `scene` whose p99 from submit to result, paced, is under the frame time.
/// A number of cameras that is too slow gets a second chance, because one hiccup of a busy computer is enough
/// to miss the 99th percentile of a short run. `conditions.rate_hz` is not used. `progress` is told each
/// attempt.
std::vector<Headline> find_headlines(const Target& target, Scene& scene, const Expected& expected,
                                     const std::vector<double>& rates_hz, const Conditions& conditions,
                                     unsigned threads,
                                     const std::function<void(const std::string&)>& progress);

}  // namespace glint::bench
