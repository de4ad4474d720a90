// SPDX-License-Identifier: MIT
// Goals against runs: median and worst over the seeds, pass or miss.
#pragma once

#include <span>
#include <vector>

#include "benchmarks/identity/figures.hpp"
#include "benchmarks/identity/run_scene.hpp"

namespace glint::identity {

/// Of one figure over the seeds, worst as the figure has it (the least recall, the most ghosts).
struct Spread {
  double median = 0.0, worst = 0.0;
};

struct Verdict {
  const BenchmarkScene* scene = nullptr;
  const Goal* goal = nullptr;
  Spread glint, plain;  ///< of a relative goal: ratios
  bool pass = false;    ///< glint's
};

Spread spread_of(const Figure& figure, std::vector<double> values);

/// One for each goal of each scene that was run, in order.
std::vector<Verdict> verdicts(std::span<const SceneRun> runs);

/// Scenes in the order in which they were run.
std::vector<const BenchmarkScene*> scenes_of(std::span<const SceneRun> runs);

/// That figure of all runs of a scene.
std::vector<double> values_of(std::span<const SceneRun> runs, const BenchmarkScene& scene,
                              const Figure& figure, IdentityResult SceneRun::*tracker);

}  // namespace glint::identity
