// SPDX-License-Identifier: MIT
// Frames in, 3D points out: latency at the camera's rate, and the rate without waiting, as Markdown tables.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "gpu/background.hpp"
#include "host/output/latency_histogram.hpp"
#include "host/pipeline/frame_input.hpp"
#include "host/pipeline/learn_background.hpp"
#include "host/pipeline/track_pipeline.hpp"
#include "host/sim/frame_loop.hpp"
#include "host/sim/rig.hpp"
#include "host/sim/sim_source.hpp"

namespace glint::benchmarks {
namespace {

struct Options {
  SimOptions sim;
  double seconds = 10.0;
  std::uint64_t length = 30;  // rendered ticks
  std::vector<std::string> devices;
};

struct Result {
  LatencyHistogram detection, end_to_end;
  std::uint64_t ticks = 0, warm_up = 0, points = 0, missed = 0;
  double wall_s = 0.0;
};

Result run(const Options& o, const Scene& scene, const std::string& device, std::uint64_t ticks, bool paced) {
  const Calibration rig = sim_calibration(o.sim);
  std::vector<gpu::Lens> lenses;
  for (const CameraCalibration& c : rig.cameras)
    lenses.push_back({c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3});
  FrameInputOptions input_options;
  input_options.device = device;
  input_options.pace = {paced ? Pace::Rate : Pace::Fastest, o.sim.rate_hz};
  auto input = std::make_unique<FrameInput>(std::make_unique<FrameLoop>(scene, o.length, ticks, paced),
                                            lenses, input_options);
  SimSource to_learn_from(scene);
  const LearntBackgrounds learnt = learn_backgrounds(to_learn_from, 30, 12);
  for (std::uint32_t camera = 0; camera < learnt.cameras.size(); ++camera)
    input->set_background(camera, learnt.cameras[camera]);

  MatchOptions match;
  match.marker_radius_m = o.sim.marker_radius_m;
  TrackPipeline pipeline(std::move(input), rig, match, {});
  Result result;
  result.warm_up = std::min<std::uint64_t>(ticks / 4, 50);
  std::uint64_t seen = 0;
  Timestamp first{}, last{};
  const ReadStatus end = pipeline.run([&](const TickResult& tick) {
    if (seen++ < result.warm_up) return;
    if (result.ticks == 0) first = tick.finished;
    last = tick.finished;
    ++result.ticks;
    result.points += tick.points.size();
    result.detection.add(tick.detection_s());
    result.end_to_end.add(tick.end_to_end_s());
  });
  if (end == ReadStatus::Failed) throw std::runtime_error(device + ": " + pipeline.problem());
  const InputCounters counters = pipeline.input().counters();
  result.missed =
      counters.dropped + counters.late + counters.source.no_slot + pipeline.counters().results_dropped;
  result.wall_s = seconds_between(first, last);
  return result;
}

void print_row(const std::string& name, const Result& r) {
  const auto ms = [](double seconds) { return seconds * 1e3; };
  std::printf(
      "| %s | %.1f | %.3f | %.3f | %.3f | %.3f | %.3f | %.1f | %llu of %llu |\n", name.c_str(),
      static_cast<double>(r.ticks - 1) / r.wall_s, ms(r.detection.quantile_s(0.5)),
      ms(r.end_to_end.quantile_s(0.5)), ms(r.end_to_end.quantile_s(0.9)), ms(r.end_to_end.quantile_s(0.99)),
      ms(r.end_to_end.max_s()), static_cast<double>(r.points) / static_cast<double>(r.ticks),
      static_cast<unsigned long long>(r.missed), static_cast<unsigned long long>(r.ticks + r.warm_up));
  std::fflush(stdout);
}

void print_head() {
  std::printf(
      "| device | ticks/s | detection p50 ms | end to end p50 ms | p90 | p99 | max | points per tick | "
      "missed |\n"
      "|---|---|---|---|---|---|---|---|---|\n");
}

int run_all(int argc, char** argv) {
  Options o;
  CLI::App app{"frames in, points out"};
  app.add_option("--device", o.devices, "as for glint track; several are measured one after the other");
  app.add_option("--cameras", o.sim.cameras)->capture_default_str()->check(CLI::Range(2u, gpu::kMaxCameras));
  app.add_option("--markers", o.sim.markers)->capture_default_str()->check(CLI::Range(1u, 500u));
  app.add_option("--rate", o.sim.rate_hz, "frame sets per second of the paced run")
      ->capture_default_str()
      ->check(CLI::Range(1.0, 1000.0));
  app.add_option("--seconds", o.seconds, "length of each run")
      ->capture_default_str()
      ->check(CLI::Range(0.5, 600.0));
  CLI11_PARSE(app, argc, argv);
  if (o.devices.empty()) {
    o.devices = {"cpu"};
    for (const gpu::DeviceInfo& device : gpu::list_devices()) {
      if (device.usable) o.devices.push_back(device.uuid);
    }
  }
  const auto name_of = [](const std::string& device) {
    for (const gpu::DeviceInfo& info : gpu::list_devices()) {
      if (info.uuid == device) return info.name + (info.software ? " (software, no GPU)" : "");
    }
    return device;
  };
  const Scene scene(o.sim);
  const auto ticks = static_cast<std::uint64_t>(o.seconds * o.sim.rate_hz);
  std::printf("\n## %u cameras of %ux%u px, %u markers, %g Hz\n\n", o.sim.cameras, o.sim.width_px,
              o.sim.height_px, o.sim.markers, o.sim.rate_hz);
  print_head();
  for (const std::string& device : o.devices) print_row(name_of(device), run(o, scene, device, ticks, true));
  std::printf("\nWithout waiting: the next set is read while the one before is tracked.\n\n");
  print_head();
  for (const std::string& device : o.devices) print_row(name_of(device), run(o, scene, device, ticks, false));
  return 0;
}

}  // namespace
}  // namespace glint::benchmarks

int main(int argc, char** argv) {
  try {
    return glint::benchmarks::run_all(argc, argv);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pipeline: %s\n", error.what());
    return 1;
  }
}
