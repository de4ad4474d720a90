// SPDX-License-Identifier: MIT
// Scenes as data; docs/identity-benchmark.md says why these.
#include "benchmarks/identity/scenes.hpp"

#include <algorithm>

#include "host/base/error.hpp"

namespace glint::identity {
namespace {

constexpr double kMm = 1e-3;
constexpr std::uint64_t kMinute = 5400;  // ticks

// Of one run in twenty, 1 lies outside the 95 % band by chance: the median over the seeds tells.
constexpr Goal kHonest{"nees_outside", 0.0, {}, true};

BenchmarkScene rod(std::string name, std::string text, double error_px, double pair_rms_m) {
  BenchmarkScene scene{std::move(name), std::move(text), {}, error_px, kMinute, {}};
  scene.options.motion = SimMotion::Wand;
  scene.options.wand_m = {0.0, 0.589};
  scene.options.markers = 2;
  if (pair_rms_m > 0.0) scene.goals = {{"pair_rms", pair_rms_m}, {"mixed", 0.0}};
  return scene;
}

BenchmarkScene balls(std::string name, std::string text, std::uint32_t markers, std::vector<Goal> goals) {
  BenchmarkScene scene{std::move(name), std::move(text), {}, 0.0, 900, std::move(goals)};
  scene.options.markers = markers;
  return scene;
}

BenchmarkScene bodies(std::string name, std::string text, SimMotion motion, std::uint32_t count,
                      std::vector<Goal> goals) {
  BenchmarkScene scene{std::move(name), std::move(text), {}, 0.0, 900, std::move(goals)};
  scene.options.motion = motion;
  scene.options.bodies.count = count;
  scene.options.markers = count * scene.options.bodies.markers;
  return scene;
}

void add_rods(std::vector<BenchmarkScene>& scenes) {
  scenes.push_back(rod("rod", "rod of two markers 58.9 cm apart, waved for 60 s", 0.0, 0.025 * kMm));
  scenes.push_back(rod("rod-0.3px", "the same, 0.3 px calibration error", 0.3, 0.12 * kMm));
  BenchmarkScene person = rod("rod-person", "the same rod, hidden by the person who waves it", 0.0, 0.0);
  person.options.person = true;
  person.goals = {{"recall", 0.999}, {"worst", 1.0 * kMm}};
  scenes.push_back(std::move(person));
}

void add_balls(std::vector<BenchmarkScene>& scenes) {
  struct Row {
    std::uint32_t markers;
    double rms_m, recall_with_missing;
  };
  constexpr Row kRows[] = {
      {20, 0.035 * kMm, 0.999}, {50, 0.04 * kMm, 0.998}, {100, 0.05 * kMm, 0.995}, {200, 0.08 * kMm, 0.99}};
  for (const Row& row : kRows) {
    const std::string number = std::to_string(row.markers);
    scenes.push_back(balls("markers-" + number, number + " independent markers", row.markers,
                           {{"recall", 0.9999},
                            {"rms", row.rms_m},
                            {"worst", 2.0 * kMm},
                            {"ghosts_per_tick", 0.001},
                            {"silent_swaps", 0.0}}));
  }
  for (const Row& row : kRows) {
    const std::string number = std::to_string(row.markers);
    BenchmarkScene scene =
        balls("missing-" + number, number + " markers, 10 % missing, 0.3 px calibration error", row.markers,
              {{"recall", row.recall_with_missing}, {"silent_swaps", 0.0}});
    scene.calibration_error_px = 0.3;
    scene.options.faults.missing_rate = 0.1;
    scenes.push_back(std::move(scene));
  }
}

void add_bodies(std::vector<BenchmarkScene>& scenes) {
  BenchmarkScene eight =
      bodies("bodies-8", "8 bodies of 5 markers in 0.2 m, 30 % missing, 1 px calibration error",
             SimMotion::Tumbling, 8, {{"recall", 0.99}, {"ghosts_per_tick", 0.01}, {"silent_swaps", 0.0}});
  eight.calibration_error_px = 1.0;
  eight.options.faults.missing_rate = 0.3;
  scenes.push_back(std::move(eight));
  scenes.push_back(bodies("tumbling-3", "3 bodies tumbling at up to 10 m/s and 110 m/s2", SimMotion::Tumbling,
                          3, {{"recall", 0.9995}, {"worst", 1.0 * kMm}, {"longest_gap", 1.0}}));
  BenchmarkScene crossing =
      bodies("crossing-2", "two identical bodies crossing 100 times, 5 cm apart at closest",
             SimMotion::Crossing, 2, {{"silent_swaps", 0.0}});
  crossing.options.bodies.identical = true;
  crossing.ticks = static_cast<std::uint64_t>(100.0 * crossing.options.bodies.crossing_period_s *
                                              crossing.options.rate_hz);
  scenes.push_back(std::move(crossing));
}

void add_hard_cases(std::vector<BenchmarkScene>& scenes) {
  scenes.push_back(balls("thrown", "one marker thrown and bouncing at up to 10 m/s", 1,
                         {{"longest_gap", 1.0}, {"fragments", 0.0}, {"swaps", 0.0}}));
  BenchmarkScene pairs = balls("pairs", "10 pairs of markers that touch, part, and slide past each other", 20,
                               {{"fragments", 0.0}, {"rms", 0.04 * kMm}, {"worst", 0.5 * kMm}});
  pairs.options.motion = SimMotion::Pairs;
  scenes.push_back(std::move(pairs));
  for (const std::uint32_t cameras : {2u, 3u}) {
    const std::string number = cameras == 2 ? "two" : "three";
    BenchmarkScene few = balls(number + "-cameras-50", "only " + number + " cameras, 50 markers", 50,
                               {{"recall", 0.998}, {"silent_swaps", 0.0}});
    few.options.cameras = cameras;
    scenes.push_back(std::move(few));
  }
  BenchmarkScene off = balls("camera-off-20", "20 markers; one camera off for 1 s, then another", 20,
                             {{"recall", 0.9995}, {"recovery", 2.0}});
  off.options.faults.off = {{0, 270, 90}, {2, 540, 90}};
  scenes.push_back(std::move(off));
  for (const int quality : {80, 50}) {
    BenchmarkScene jpeg = balls("jpeg-" + std::to_string(quality),
                                "20 markers through JPEG of quality " + std::to_string(quality), 20,
                                {{"rms", quality == 80 ? 1.5 : 2.5, "markers-20"}});
    jpeg.options.jpeg_quality = quality;
    scenes.push_back(std::move(jpeg));
  }
  BenchmarkScene blinking =
      balls("blinking", "empty room, blinking pixels, 10,000 frames", 0, {{"ghosts_per_tick", 0.0}});
  blinking.options.faults.blinks_per_frame = 2.0;
  blinking.ticks = 10'000;
  scenes.push_back(std::move(blinking));
}

std::vector<BenchmarkScene> make_scenes() {
  std::vector<BenchmarkScene> scenes;
  add_rods(scenes);
  add_balls(scenes);
  add_bodies(scenes);
  add_hard_cases(scenes);
  for (BenchmarkScene& scene : scenes)
    if (scene.options.markers > 0) scene.goals.push_back(kHonest);
  return scenes;
}

}  // namespace

SimOptions BenchmarkScene::options_with(std::uint64_t seed) const {
  SimOptions with_seed = options;
  with_seed.seed = seed;
  return with_seed;
}

std::span<const BenchmarkScene> benchmark_scenes() {
  static const std::vector<BenchmarkScene> scenes = make_scenes();
  return scenes;
}

const BenchmarkScene& find_scene(std::string_view name) {
  const std::span<const BenchmarkScene> scenes = benchmark_scenes();
  const auto found = std::find_if(scenes.begin(), scenes.end(),
                                  [&](const BenchmarkScene& scene) { return scene.name == name; });
  if (found != scenes.end()) return *found;
  std::string names;
  for (const BenchmarkScene& scene : scenes) names += (names.empty() ? "" : ", ") + scene.name;
  throw UsageError("there is no scene " + std::string(name) + "; there are " + names);
}

}  // namespace glint::identity
