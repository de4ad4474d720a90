// SPDX-License-Identifier: MIT
// Runs in parallel share nothing but the list of what is to be done.
#include "benchmarks/identity/run_scene.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>

#include "benchmarks/identity/plain.hpp"
#include "benchmarks/identity/product.hpp"

namespace glint::identity {

SceneRun run_scene(const BenchmarkScene& scene, std::uint64_t seed, std::uint64_t ticks) {
  const auto begin = std::chrono::steady_clock::now();
  SceneRun run{&scene, seed, ticks == 0 ? scene.ticks : ticks, {}, {}, {}, {}, 0.0};
  const Scene truth(scene.options_with(seed));
  const Calibration calibration = given_calibration(truth, scene.calibration_error_px);
  const double radius_m = truth.options().marker_radius_m;
  IdentityScore of_glint(truth), of_plain(truth);
  PlainTracker plain(calibration, radius_m);
  std::vector<IdentitySample> plain_samples;
  std::optional<BodiesKnown> bodies_known;
  if (truth.bodies() > 0) bodies_known.emplace(truth, calibration);
  auto input = std::make_unique<TappedInput>(open_scene(truth, run.ticks), [&](const TickBlobs& tick) {
    plain.track(tick.cameras, plain_samples);
    of_plain.add(number(tick.trigger), plain_samples);
    if (bodies_known) bodies_known->take(tick);
  });
  track(std::move(input), calibration, radius_m,
        [&](std::uint64_t tick, std::span<const IdentitySample> samples) { of_glint.add(tick, samples); });
  run.glint = of_glint.result();
  run.plain = of_plain.result();
  if (bodies_known) {
    run.bodies_known = bodies_known->markers();
    run.poses = bodies_known->poses();
  }
  run.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return run;
}

std::vector<SceneRun> run_scenes(std::span<const BenchmarkScene* const> scenes, std::uint64_t seeds,
                                 std::uint64_t ticks, unsigned jobs,
                                 const std::function<void(const SceneRun&)>& done) {
  std::vector<const BenchmarkScene*> all(scenes.begin(), scenes.end());
  for (const BenchmarkScene* scene : scenes) {
    for (const Goal& goal : scene->goals) {
      if (goal.relative_to.empty()) continue;
      const BenchmarkScene* other = &find_scene(goal.relative_to);
      if (std::find(all.begin(), all.end(), other) == all.end()) all.push_back(other);
    }
  }
  std::vector<SceneRun> runs(all.size() * seeds);
  std::atomic<std::size_t> next{0};
  std::mutex mutex;
  std::exception_ptr failure;
  const auto work = [&] {
    for (std::size_t at = next++; at < runs.size(); at = next++) {
      try {
        runs[at] = run_scene(*all[at / seeds], at % seeds + 1, ticks);
        const std::scoped_lock lock(mutex);
        done(runs[at]);
      } catch (...) {
        const std::scoped_lock lock(mutex);
        if (!failure) failure = std::current_exception();
        next = runs.size();
      }
    }
  };
  {
    std::vector<std::jthread> threads;
    for (unsigned i = 1; i < jobs; ++i) threads.emplace_back(work);
    work();
  }
  if (failure) std::rethrow_exception(failure);
  return runs;
}

}  // namespace glint::identity
