// SPDX-License-Identifier: MIT
// The steps one by one, under Google Benchmark.
#include <benchmark/benchmark.h>

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gpu/background.hpp"
#include "gpu/cpu/detector_cpu.hpp"
#include "gpu/detector.hpp"
#include "gpu/lens.hpp"
#include "host/bench/scene.hpp"

namespace glint::benchmarks {
namespace {

using bench::Scene;
using bench::SceneOptions;

Scene make_scene(benchmark::State& state) {
  SceneOptions options;
  options.blobs_per_camera = static_cast<unsigned>(state.range(0));
  return Scene(options);
}

gpu::Lens scene_lens() {
  SceneOptions options;
  options.cameras = options.ticks = 1;
  return Scene(options).formats()[0].lens;
}

void detect(benchmark::State& state, const Scene& scene, gpu::Detector& detector) {
  for (unsigned i = 0; i < scene.options().cameras; ++i) detector.set_limit(i, scene.limit(i));
  std::vector<std::vector<gpu::ImageView>> sets;
  for (unsigned tick = 0; tick < scene.options().ticks; ++tick) sets.push_back(scene.images(tick));
  gpu::BlobBatch batch;
  std::size_t tick = 0;
  std::map<std::string, double> stage_s;
  for (auto _ : state) {
    if (detector.submit(sets[tick++ % sets.size()]) != gpu::RunStatus::Ok ||
        detector.collect(batch) != gpu::RunStatus::Ok) {
      state.SkipWithError(detector.last_error().c_str());
      break;
    }
    benchmark::DoNotOptimize(batch.cameras.data());
    for (const gpu::StageTime& stage : batch.stages) stage_s[stage.name] += stage.seconds;
  }
  for (const auto& [name, seconds] : stage_s) {
    state.counters[name + " us"] = benchmark::Counter(seconds * 1e6, benchmark::Counter::kAvgIterations);
  }
  state.SetLabel(detector.device_name());
}

void reference(benchmark::State& state) {
  const Scene scene = make_scene(state);
  detect(state, scene, *gpu::make_reference_detector(scene.formats(), {}));
}
BENCHMARK(reference)->Arg(0)->Arg(20)->Arg(200)->Unit(benchmark::kMillisecond)->UseRealTime();

/// Arguments: blobs per camera, threads, index of the kernels.
void native(benchmark::State& state) {
  const auto kernels = static_cast<std::size_t>(state.range(2));
  if (kernels >= gpu::row_kernels().size()) {
    state.SkipWithError("this CPU does not have as many instruction sets");
    return;
  }
  const Scene scene = make_scene(state);
  gpu::DetectorOptions options;
  options.threads = static_cast<unsigned>(state.range(1));
  detect(state, scene, *gpu::make_cpu_detector(scene.formats(), options, gpu::row_kernels()[kernels]));
}
BENCHMARK(native)
    ->ArgsProduct({{0, 20, 200},
                   {1, 2},
                   benchmark::CreateDenseRange(0, static_cast<long>(gpu::row_kernels().size()) - 1, 1)})
    ->Unit(benchmark::kMillisecond)
    ->UseRealTime();

/// On a Vulkan device, with the time that it says it spent on each stage. Argument: blobs per camera.
void vulkan(benchmark::State& state, const std::string& device) {
  Scene scene = make_scene(state);
  const auto detector = gpu::make_detector(device, scene.formats(), {});
  (void)detector->adopt_frame_memory(scene.memory());
  detect(state, scene, *detector);
}

void undistort(benchmark::State& state) {
  const gpu::Lens lens = scene_lens();
  double x = 0.0, y = 0.0;
  for (auto _ : state) {
    x = x < 1270.0 ? x + 9.7 : 0.0;
    y = y < 790.0 ? y + 7.3 : 0.0;
    benchmark::DoNotOptimize(gpu::undistort(lens, x, y));
  }
}
BENCHMARK(undistort);

void undistort_blob(benchmark::State& state) {
  const gpu::Lens lens = scene_lens();
  double x = 0.0, y = 0.0;
  for (auto _ : state) {
    x = x < 1270.0 ? x + 9.7 : 0.0;
    y = y < 790.0 ? y + 7.3 : 0.0;
    benchmark::DoNotOptimize(gpu::undistort_blob(lens, x, y, 25.0, 1.0, 25.0));
  }
}
BENCHMARK(undistort_blob);

/// Argument: frames to learn from.
void learn_background(benchmark::State& state) {
  SceneOptions options;
  options.cameras = 1;
  options.ticks = static_cast<unsigned>(state.range(0));
  const Scene scene(options);
  gpu::BackgroundLearner learner;
  for (unsigned tick = 0; tick < options.ticks; ++tick) learner.add(scene.images(tick)[0]);
  for (auto _ : state) benchmark::DoNotOptimize(learner.learn(40).limit.data());
}
BENCHMARK(learn_background)->Arg(5)->Arg(30)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace glint::benchmarks

int main(int argc, char** argv) {
  for (const glint::gpu::DeviceInfo& device : glint::gpu::list_devices()) {
    if (!device.usable) continue;
    benchmark::RegisterBenchmark(("vulkan" + std::to_string(device.index)).c_str(), glint::benchmarks::vulkan,
                                 device.uuid)
        ->ArgsProduct({{0, 20, 200, 2000}})
        ->Unit(benchmark::kMillisecond)
        ->UseRealTime();
  }
  benchmark::Initialize(&argc, argv);
  if (benchmark::ReportUnrecognizedArguments(argc, argv)) return 1;
  benchmark::RunSpecifiedBenchmarks();
  benchmark::Shutdown();
  return 0;
}
