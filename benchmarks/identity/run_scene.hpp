// SPDX-License-Identifier: MIT
// One scene, one seed, several trackers, the same blobs.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "benchmarks/identity/scenes.hpp"
#include "host/sim/identity_score.hpp"
#include "host/sim/pose_score.hpp"

namespace glint::identity {

struct SceneRun {
  const BenchmarkScene* scene = nullptr;
  std::uint64_t seed = 1, ticks = 0;
  IdentityResult glint, plain;
  /// Only of scenes with rigid bodies: glint a second time, with the bodies known.
  IdentityResult bodies_known;
  std::optional<PoseResult> poses;
  double wall_s = 0.0;
};

/// `ticks` 0: as many as the scene has. Throws Error, gpu::Error.
SceneRun run_scene(const BenchmarkScene& scene, std::uint64_t seed, std::uint64_t ticks = 0);

/// Every scene with seeds 1 to `seeds`, `jobs` at a time, and the scenes that their goals refer to; in the
/// order of scenes, then seeds. `done` is called after each, by one thread at a time. Throws what the first
/// run that failed threw.
std::vector<SceneRun> run_scenes(std::span<const BenchmarkScene* const> scenes, std::uint64_t seeds,
                                 std::uint64_t ticks, unsigned jobs,
                                 const std::function<void(const SceneRun&)>& done);

}  // namespace glint::identity
