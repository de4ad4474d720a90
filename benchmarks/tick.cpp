// SPDX-License-Identifier: MIT
// A given number of detections on the benchmark scene and nothing else: for callgrind, perf, and wall times
// that no other contender disturbs.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "gpu/cpu/detector_cpu.hpp"
#include "host/bench/scene.hpp"

// One detection, under a name that a profiler can be told to count between its call and its return:
// `valgrind --tool=callgrind --toggle-collect=glint_tick`.
extern "C" [[gnu::noinline]] bool glint_tick(glint::gpu::Detector& detector,
                                             const std::vector<glint::gpu::ImageView>& images,
                                             glint::gpu::BlobBatch& batch) noexcept {
  return detector.submit(images) == glint::gpu::RunStatus::Ok &&
         detector.collect(batch) == glint::gpu::RunStatus::Ok;
}

namespace glint::benchmarks {
namespace {

using bench::Scene;
using bench::SceneOptions;

struct Options {
  std::string device = "cpu", kernels;
  gpu::DetectorOptions detector;
  SceneOptions scene;
  unsigned warm_up = 8, iterations = 1000;
};

std::unique_ptr<gpu::Detector> make_detector(const Options& options, const Scene& scene) {
  if (options.kernels.empty()) return gpu::make_detector(options.device, scene.formats(), options.detector);
  if (options.device != "cpu") throw gpu::Error("--kernels is for --device cpu only");
  std::string known;
  for (const gpu::RowKernels& kernels : gpu::row_kernels()) {
    if (kernels.name == options.kernels)
      return gpu::make_cpu_detector(scene.formats(), options.detector, kernels);
    known += std::string(" ") + kernels.name;
  }
  throw gpu::Error("--kernels " + options.kernels + ": this CPU has" + known);
}

void run(const Options& options) {
  Scene scene(options.scene);
  const auto detector = make_detector(options, scene);
  detector->adopt_frame_memory(scene.memory());
  for (unsigned i = 0; i < options.scene.cameras; ++i) detector->set_limit(i, scene.limit(i));
  std::vector<std::vector<gpu::ImageView>> sets;
  for (unsigned tick = 0; tick < options.scene.ticks; ++tick) sets.push_back(scene.images(tick));

  gpu::BlobBatch batch;
  std::size_t found = 0;
  const auto detect = [&](unsigned n, bool counted) {
    // Not glint_tick() while warming up: a profiler would count it.
    const auto& images = sets[n % sets.size()];
    const bool ok = counted ? glint_tick(*detector, images, batch)
                            : detector->submit(images) == gpu::RunStatus::Ok &&
                                  detector->collect(batch) == gpu::RunStatus::Ok;
    if (!ok) throw gpu::Error(detector->device_name() + ": " + detector->last_error());
  };
  for (unsigned n = 0; n < options.warm_up; ++n) detect(n, false);
  std::vector<double> times_us;
  times_us.reserve(options.iterations);
  for (unsigned n = 0; n < options.iterations; ++n) {
    const auto start = std::chrono::steady_clock::now();
    detect(n, true);
    const std::chrono::duration<double, std::micro> taken = std::chrono::steady_clock::now() - start;
    times_us.push_back(taken.count());
    for (const gpu::CameraBlobs& camera : batch.cameras) found += camera.found;
  }
  std::sort(times_us.begin(), times_us.end());
  std::printf("%s: min %.1f us, p10 %.1f, median %.1f, p90 %.1f; %.1f blobs per tick\n",
              detector->device_name().c_str(), times_us.front(), times_us[times_us.size() / 10],
              times_us[times_us.size() / 2], times_us[times_us.size() * 9 / 10],
              static_cast<double>(found) / options.iterations);
}

int main(int argc, char** argv) {
  Options options;
  options.detector.threads = 1;
  CLI::App app{"runs detections on the benchmark scene"};
  app.add_option("--device", options.device, "cpu, or a Vulkan device by index, UUID or part of its name")
      ->capture_default_str();
  app.add_option("--kernels", options.kernels, "cpu only: AVX2, SSE2 or portable instead of the best");
  app.add_option("--threads", options.detector.threads, "cpu only")->capture_default_str();
  app.add_option("--scene", options.scene.blobs_per_camera, "blobs per camera")->capture_default_str();
  app.add_option("--cameras", options.scene.cameras)
      ->capture_default_str()
      ->check(CLI::Range(1u, gpu::kMaxCameras));
  app.add_option("--ticks", options.scene.ticks, "different frame sets, shown in rotation")
      ->capture_default_str()
      ->check(CLI::Range(1u, 64u));
  app.add_option("--iterations", options.iterations)->capture_default_str()->check(CLI::Range(1u, 10000000u));
  CLI11_PARSE(app, argc, argv);
  try {
    run(options);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "tick: %s\n", error.what());
    return 1;
  }
  return 0;
}

}  // namespace
}  // namespace glint::benchmarks

int main(int argc, char** argv) { return glint::benchmarks::main(argc, argv); }
