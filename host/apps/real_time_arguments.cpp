// SPDX-License-Identifier: MIT
// Words to RealTimeOptions.
#include "host/apps/real_time_arguments.hpp"

#include <memory>
#include <utility>

#include "host/base/error.hpp"
#include "host/realtime/cpu_list.hpp"
#include "host/realtime/scheduler_calls.hpp"

namespace glint::apps {
namespace {

RealTimeMode mode_of(const RealTimeArguments& a, bool cameras) {
  if (a.mode.empty()) return cameras ? RealTimeMode::Auto : RealTimeMode::Off;
  for (const RealTimeMode mode : {RealTimeMode::Off, RealTimeMode::Auto, RealTimeMode::Require}) {
    if (a.mode == name_of(mode)) return mode;
  }
  throw UsageError("--realtime " + a.mode + ": must be auto, off or require");
}

}  // namespace

void add_real_time_options(CLI::App& command, RealTimeArguments& a) {
  command.add_option(
      "--realtime", a.mode,
      "threads ahead of other programs, memory locked: auto, off or require (v4l2: auto, sim: off)");
  command.add_option("--pin", a.cpus, "CPUs for capturing and tracking, like 2,3 or 2-3 (v4l2 and sim)");
}

std::optional<RealTime> make_real_time(const RealTimeArguments& a, const RunArguments& run) {
  const bool cameras = run.source.starts_with("v4l2:"), paced_sim = run.source == "sim" && run.pace != "fast";
  const RealTimeMode mode = mode_of(a, cameras);
  if (!cameras && !paced_sim) {
    if (mode == RealTimeMode::Require) throw UsageError("--realtime=require: only for live sources");
    if (!a.cpus.empty()) throw UsageError("--pin: only for live sources");
    return std::nullopt;
  }
  RealTimeOptions options;
  options.mode = mode;
  const auto cpus = parse_cpu_list(a.cpus);
  if (!cpus) throw UsageError("--pin " + a.cpus + ": must be a list of CPUs, like 2,3 or 2-3");
  options.cpus = *cpus;
  if (mode == RealTimeMode::Off && options.cpus.empty()) return std::nullopt;
  return std::optional<RealTime>(std::in_place, std::move(options), std::make_shared<KernelSchedulerCalls>());
}

}  // namespace glint::apps
