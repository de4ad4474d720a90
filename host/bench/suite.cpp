// SPDX-License-Identifier: MIT
// The order of things: scene by scene, so that all devices see the same pictures within a short time.
#include "host/bench/suite.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <exception>
#include <optional>

#include "gpu/vulkan/shader_hash.hpp"
#include "host/base/ids.hpp"
#include "host/bench/check.hpp"
#include "host/bench/headline.hpp"
#include "host/bench/machine.hpp"
#include "host/bench/measure.hpp"

namespace glint::bench {
namespace {

constexpr unsigned kDrawnCameras = 4;  // further cameras show copies: drawing takes longer than measuring
constexpr unsigned kManyCameras = 8;   // from here on, half as many different ticks
constexpr SceneKey kHeadlineScene{0, 1280, 800, 20, SceneOptions{}.noise_grey};

SceneOptions scene_options(const SceneKey& key) {
  SceneOptions options;
  options.cameras = key.cameras;
  options.width_px = key.width_px;
  options.height_px = key.height_px;
  options.blobs_per_camera = key.blobs;
  options.noise_grey = key.noise_grey;
  options.drawn_cameras = kDrawnCameras;
  options.ticks = key.cameras > kManyCameras ? 2 : 4;
  return options;
}

/// Core seconds that went to other programs so far.
std::optional<double> others_busy_s() {
  const std::optional<double> all = busy_core_s();
  return all ? std::optional(*all - process_cpu_s()) : std::nullopt;
}

/// Fills in all of a row but its scene.
void measure(const Target& target, Scene& scene, const Expected& expected, const SuiteOptions& options,
             DeviceResult& device, Row& row) {
  const unsigned cameras = row.scene.cameras;
  const Conditions& conditions = options.conditions;
  const PreparedDetector made = make_detector(target, scene, cameras, {options.threads, conditions.depth});
  device.name = made.detector->device_name();
  row.adopted_frame_memory = made.adopted_frame_memory;
  if (row.problem = expected.difference(*made.detector); !row.problem.empty()) {
    row.outcome = Outcome::Wrong;
    return;
  }
  Drive drive(scene, expected, *made.detector, cameras);
  const std::optional<double> load_before = others_busy_s();
  const Timestamp began = std::chrono::steady_clock::now();
  warm_up(drive, conditions);
  measure_latency(drive, conditions, row);
  measure_throughput(drive, conditions, row);
  row.paced = measure_pace(drive, conditions);
  if (const std::optional<double> load_after = others_busy_s(); load_before && load_after) {
    row.other_load_cores =
        std::max(0.0, *load_after - *load_before) / seconds_between(began, std::chrono::steady_clock::now());
  }
  row.outcome = drive.outcome();
  row.problem = drive.problem();
  double blobs = 0.0;
  for (unsigned tick = 0; tick < scene.options().ticks; ++tick)
    blobs += static_cast<double>(expected.found(tick, cameras));
  row.blobs_per_tick = blobs / scene.options().ticks;
}

Row measured_row(const Target& target, Scene& scene, const Expected& expected, const SceneKey& key,
                 const SuiteOptions& options, DeviceResult& device) {
  Row row;
  row.scene = key;
  try {
    measure(target, scene, expected, options, device, row);
  } catch (const std::exception& e) {
    row.outcome = Outcome::Failed;
    row.problem = e.what();
  }
  if (row.outcome == Outcome::Ok) return row;
  Row void_row;  // wrong or broken: no figures
  void_row.scene = key;
  void_row.outcome = row.outcome;
  void_row.problem = row.problem;
  return void_row;
}

}  // namespace

void check_scenes(const std::vector<SceneKey>& scenes) {
  for (SceneKey key : scenes) {
    key.cameras = 1;
    const Scene scene(scene_options(key));
    const Expected expected(scene);
  }
}

Results run_suite(const SuiteOptions& options, const Progress& progress) {
  Results results;
  results.started_utc = utc_now();
  results.machine = describe_machine();
  results.conditions = options.conditions;
  char hash[20];
  std::snprintf(hash, sizeof hash, "%016llx", static_cast<unsigned long long>(gpu::shader_hash()));
  results.shader_hash = hash;
  for (const Target& target : options.targets) results.devices.push_back(describe(target));
  for (const SceneKey& key : options.scenes) {
    Scene scene(scene_options(key));
    const Expected expected(scene);
    for (std::size_t d = 0; d < options.targets.size(); ++d) {
      DeviceResult& device = results.devices[d];
      progress(device.name + ": " + display_name(key));
      device.rows.push_back(measured_row(options.targets[d], scene, expected, key, options, device));
    }
  }
  if (options.headline_rates_hz.empty()) return results;
  results.headline_scene = kHeadlineScene;
  SceneKey most = kHeadlineScene;
  most.cameras = gpu::kMaxCameras;
  Scene scene(scene_options(most));
  const Expected expected(scene);
  for (std::size_t d = 0; d < options.targets.size(); ++d) {
    DeviceResult& device = results.devices[d];
    device.headlines = find_headlines(options.targets[d], scene, expected, options.headline_rates_hz,
                                      options.conditions, options.threads,
                                      [&](const std::string& text) { progress(device.name + ": " + text); });
  }
  return results;
}

}  // namespace glint::bench
