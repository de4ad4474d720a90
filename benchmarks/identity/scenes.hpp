// SPDX-License-Identifier: MIT
// The scenes of the identity benchmark and what a tracker should reach in each.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "host/sim/options.hpp"

namespace glint::identity {

/// A figure (figures.hpp) that must not be worse than a limit.
struct Goal {
  std::string_view figure;
  double limit = 0.0;              ///< SI units
  std::string_view relative_to{};  ///< a scene: the limit is times that scene's figure at the same seed
  bool median = false;             ///< judged by the median over the seeds, not by the worst
};

struct BenchmarkScene {
  std::string name, text;
  SimOptions options;
  double calibration_error_px = 0.0;  ///< of the calibration that trackers get (sim: disturbed())
  std::uint64_t ticks = 900;
  std::vector<Goal> goals;

  /// As it is run with that seed, from which everything random follows.
  SimOptions options_with(std::uint64_t seed) const;
};

std::span<const BenchmarkScene> benchmark_scenes();
/// Throws UsageError that lists the names.
const BenchmarkScene& find_scene(std::string_view name);

}  // namespace glint::identity
