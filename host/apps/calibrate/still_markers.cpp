// SPDX-License-Identifier: MIT
#include "host/apps/calibrate/still_markers.hpp"

#include <cstdio>
#include <map>

#include "host/apps/stop_signal.hpp"
#include "host/base/error.hpp"
#include "host/pipeline/track_step.hpp"

namespace glint::apps {
namespace {

constexpr double kStill_m = 0.001;

struct Seen {
  std::uint64_t ticks = 0;
  Eigen::Vector3d sum = Eigen::Vector3d::Zero(), squares = Eigen::Vector3d::Zero();
};

std::vector<Eigen::Vector3d> means_of(const std::map<std::uint32_t, Seen>& seen, std::uint64_t ticks) {
  std::vector<Eigen::Vector3d> places;
  for (const auto& [id, marker] : seen) {
    if (2 * marker.ticks < ticks) continue;
    const auto count = static_cast<double>(marker.ticks);
    const Eigen::Vector3d mean = marker.sum / count;
    const double variance = (marker.squares / count - mean.cwiseProduct(mean)).sum();
    if (variance > kStill_m * kStill_m) {
      char text[160];
      std::snprintf(text, sizeof text, "a marker near (%.3f, %.3f, %.3f) m moves: all must lie still",
                    mean.x(), mean.y(), mean.z());
      throw Error(text);
    }
    places.push_back(mean);
  }
  return places;
}

}  // namespace

std::vector<Eigen::Vector3d> still_markers(const RunArguments& arguments, bool quiet) {
  StopSignal stop_signal;
  OpenedRun run = open_run(arguments, true);
  TickInput& input = *run.input;
  if (!quiet) {
    std::fprintf(stderr, "glint: %s, %zu cameras, on %s\n", arguments.source.c_str(), input.cameras().size(),
                 input.device_name().c_str());
    for (const std::string& note : run.notes) std::fprintf(stderr, "glint: %s\n", note.c_str());
  }
  const StopSignal::Handler on_stop(stop_signal, [&input] { input.stop(); });
  TrackStep step(run.rig.calibration, run.rig.match, run.rig.track);
  std::map<std::uint32_t, Seen> seen;
  std::uint64_t ticks = 0;
  TickBlobs tick;
  ReadStatus status = ReadStatus::Ok;
  while ((status = input.next(tick)) == ReadStatus::Ok) {
    if (tick.dark) continue;
    ++ticks;
    step.take(tick);
    for (const TrackedPoint& point : step.tracked()) {
      if (point.kind != SampleKind::Measured) continue;
      Seen& marker = seen[number(point.id)];
      ++marker.ticks;
      marker.sum += point.position_in_world;
      marker.squares += point.position_in_world.cwiseProduct(point.position_in_world);
    }
  }
  if (status == ReadStatus::Failed) throw Error(input.problem());
  return means_of(seen, ticks);
}

}  // namespace glint::apps
