// SPDX-License-Identifier: MIT
#include "host/apps/calibrate/wand_samples.hpp"

#include <chrono>
#include <cstdio>

#include "host/apps/progress_line.hpp"
#include "host/apps/stop_signal.hpp"
#include "host/base/error.hpp"
#include "host/calibrate/guidance.hpp"
#include "host/target/wand_finder.hpp"

namespace glint::apps {
namespace {

std::string camera_note(const std::string& name, const WandFinderCounters& c) {
  const auto share = [&](std::uint64_t part) {
    char text[16];
    std::snprintf(text, sizeof text, "%.0f %%",
                  100.0 * static_cast<double>(part) / static_cast<double>(c.images));
    return std::string(text);
  };
  return name + " saw the target in " + share(c.found) + " of " + std::to_string(c.images) +
         " images (too few blobs " + share(c.too_few) + ", other things that shine " + share(c.no_match) +
         ", unclear " + share(c.ambiguous) + ")";
}

/// The target's markers in the blobs of all cameras, exposure by exposure.
class Collector {
 public:
  Collector(const Target& target, std::span<const SourceCamera> cameras,
            const std::vector<CameraCalibration>& lenses)
      : names_(cameras.begin(), cameras.end()) {
    samples_.target = target;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      samples_.cameras.push_back({cameras[c].name, cameras[c].size.width_px, cameras[c].size.height_px});
      finders_.emplace_back(target, lenses[c]);
    }
    guidance_.emplace(target, samples_.cameras, lenses);
  }

  void take(const TickBlobs& tick) {
    if (tick.dark) return;
    const std::size_t before = samples_.sightings.size();
    for (std::uint32_t c = 0; c < finders_.size(); ++c) {
      const bool there = (tick.frames >> c & 1u) != 0,
                 unproven = tick.unproven && (*tick.unproven >> c & 1u) != 0;
      if (!there || unproven) continue;
      for (const FoundMarker& marker : finders_[c].find(tick.cameras[c]))
        samples_.sightings.push_back({number(tick.trigger), c, marker.point, marker.pixel});
    }
    guidance_->add(std::span<const Sighting>(samples_.sightings).subspan(before));
  }

  std::string status_line() const { return guidance_->status_line(); }
  SampleSet take_samples() { return std::move(samples_); }
  std::vector<std::string> notes() const {
    std::vector<std::string> notes;
    for (std::size_t c = 0; c < finders_.size(); ++c)
      if (finders_[c].counters().images > 0)
        notes.push_back(camera_note(names_[c].name, finders_[c].counters()));
    return notes;
  }

 private:
  std::vector<SourceCamera> names_;
  SampleSet samples_;
  std::vector<WandFinder> finders_;
  std::optional<Guidance> guidance_;
};

}  // namespace

WandSamples collect_wand_samples(RunArguments arguments, const Target& target, bool quiet,
                                 const std::function<void(const Rig&)>& opened,
                                 const std::function<void(const TickBlobs&)>& on_tick) {
  if (arguments.source == "sim") {
    arguments.sim.wave_m.clear();
    for (const Eigen::Vector3d& point : target.points_in_target) arguments.sim.wave_m.push_back(point.x());
    if (!arguments.seconds && arguments.max_ticks == 0) arguments.seconds = 60.0;
    if (arguments.pace.empty()) arguments.pace = "fast";
  }
  StopSignal stop_signal;
  OpenedRun run = open_run(arguments, true);
  TickInput& input = *run.input;
  WandSamples result;
  result.lenses = run.rig.calibration.cameras;
  if (!quiet) {
    std::fprintf(stderr, "glint: %s, %zu cameras, on %s; wave the target through the whole volume%s\n",
                 arguments.source.c_str(), input.cameras().size(), input.device_name().c_str(),
                 input.live() ? ", Ctrl-C when there is enough" : "");
    for (const std::string& note : run.notes) std::fprintf(stderr, "glint: %s\n", note.c_str());
  }
  if (opened) opened(run.rig);
  const StopSignal::Handler on_stop(stop_signal, [&input] { input.stop(); });
  Collector collector(target, input.cameras(), result.lenses);
  ProgressLine progress(quiet);
  TickBlobs tick;
  ReadStatus status = ReadStatus::Ok;
  Timestamp next_line{};
  while ((status = input.next(tick)) == ReadStatus::Ok) {
    collector.take(tick);
    if (on_tick) on_tick(tick);
    if (tick.detected < next_line) continue;
    next_line = tick.detected + std::chrono::seconds(1);
    progress.show(collector.status_line());
  }
  result.samples = collector.take_samples();
  put_in_order(result.samples);
  result.samples.rate_hz = input.rate_hz();
  result.notes = collector.notes();
  if (status == ReadStatus::Failed) {
    if (result.samples.sightings.empty()) throw Error(input.problem());
    result.failure = input.problem();
  } else if (!input.problem().empty()) {
    result.notes.push_back(input.problem());
  }
  return result;
}

double sphere_radius_m(double given, const RunArguments& arguments) {
  if (given >= 0.0) return given;
  if (arguments.source == "sim") return arguments.sim.options.marker_radius_m;
  return arguments.rig_file.empty() ? 0.0 : read_rig(arguments.rig_file).marker_radius_m;
}

}  // namespace glint::apps
