// SPDX-License-Identifier: MIT
// `glint calibrate refine`: tracks whatever markers there are and improves the cameras' places by them, if it
// helps.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <numbers>

#include "host/apps/calibrate/commands.hpp"
#include "host/apps/progress_line.hpp"
#include "host/apps/run_arguments.hpp"
#include "host/apps/stop_signal.hpp"
#include "host/apps/utc_time.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/refine.hpp"
#include "host/pipeline/track_step.hpp"

namespace glint::apps {
namespace {

constexpr std::size_t kMostMarkers = 20'000;  // some seconds of work; more change nothing
constexpr double kGate_px =
    3.0;  // wider than while tracking: a camera that drifted must still find its blobs

struct RefineArguments {
  RunArguments run;
  std::string output;
  bool force = false, quiet = false;
};

SampleSet collect(const RefineArguments& a, Calibration& calibration) {
  StopSignal stop_signal;
  OpenedRun run = open_run(a.run, true);
  calibration = run.rig.calibration;
  TickInput& input = *run.input;
  std::vector<SampleCamera> cameras;
  for (const SourceCamera& camera : input.cameras())
    cameras.push_back({camera.name, camera.size.width_px, camera.size.height_px});
  TrackedSamples samples(cameras, run.rig.match.marker_radius_m);
  const StopSignal::Handler on_stop(stop_signal, [&input] { input.stop(); });
  MatchOptions options = run.rig.match;
  options.gate_px = std::max(options.gate_px, kGate_px);
  options.sigma_px = std::max(options.sigma_px, 0.3 * kGate_px);
  TrackStep step(run.rig.calibration, options, run.rig.track);
  ProgressLine progress(a.quiet);
  TickBlobs tick;
  ReadStatus status = ReadStatus::Ok;
  std::uint64_t markers = 0, ticks = 0;
  std::vector<Sighting> sightings;
  while ((status = input.next(tick)) == ReadStatus::Ok) {
    if (tick.dark) continue;
    step.take(tick);
    for (const TrackedPoint& track : step.tracked()) {
      if (track.kind != SampleKind::Measured) continue;
      const Point& point = step.points()[track.point];
      sightings.clear();
      for (std::uint32_t c = 0; c < cameras.size(); ++c) {
        if (point.blob_of_camera[c] < 0) continue;
        const gpu::BlobRecord& blob = tick.cameras[c][static_cast<std::size_t>(point.blob_of_camera[c])];
        sightings.push_back({0, c, 0, {static_cast<double>(blob.x_px), static_cast<double>(blob.y_px)}});
      }
      samples.add(sightings);
      ++markers;
    }
    if (++ticks % 100 == 0)
      progress.show(std::to_string(ticks) + " exposures, " + std::to_string(markers) + " markers");
  }
  if (status == ReadStatus::Failed) throw Error(input.problem());
  return samples.take(kMostMarkers);
}

void run(const RefineArguments& a) {
  if (!a.force && std::filesystem::exists(a.output))
    throw Error(a.output + ": exists already; --force replaces it");
  Calibration calibration;
  const SampleSet samples = collect(a, calibration);
  Refinement refinement = refine(calibration, samples);
  std::printf("%s; the camera that moved most: %.3f mm, %.4f degrees\n", refinement.reason.c_str(),
              1e3 * refinement.worst_shift_m, refinement.worst_turn_rad * 180.0 / std::numbers::pi);
  if (!refinement.better) {
    std::printf("kept as it is: nothing was written\n");
    return;
  }
  refinement.calibration.made_at = utc_now();
  refinement.calibration.made_from += ", refined";
  write_calibration(a.output, refinement.calibration, a.force);
  std::printf("wrote %s\n", a.output.c_str());
}

}  // namespace

void add_calibrate_refine(CLI::App& calibrate) {
  CLI::App* command = calibrate.add_subcommand(
      "refine", "Improve the cameras' places by markers that are tracked, if that helps");
  const auto a = std::make_shared<RefineArguments>();
  add_run_options(*command, a->run, "sim, v4l2:[DEVICE,...], images:LOCATION or blobs:FOLDER");
  command->add_option("-o,--output", a->output, "calibration file to write, if it is better")->required();
  command->add_flag("--force", a->force, "replace an existing file");
  command->add_flag("--quiet", a->quiet, "no messages");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
