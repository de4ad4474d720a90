// SPDX-License-Identifier: MIT
// The arguments that `track` and `detect` share, and the input that they open from them.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/apps/live_cameras.hpp"
#include "host/apps/sim_arguments.hpp"
#include "host/config/rig.hpp"
#include "host/pipeline/tick_input.hpp"
#include "host/realtime/real_time.hpp"
#include "host/sim/scene.hpp"
#include "host/sync/board_run.hpp"

namespace glint::apps {

struct RunArguments {
  std::string source;  ///< sim, v4l2:[DEVICE,...], images:LOCATION, blobs:FOLDER
  std::string rig_file, device, pace, background;
  std::optional<unsigned> depth, threshold;
  std::optional<std::uint32_t> min_area_px, max_area_px;
  std::optional<double> rate_hz, seconds, plane_height_m;
  std::uint64_t max_ticks = 0;
  LiveArguments live;
  SimArguments sim;
};

/// Adds SOURCE and the options to a command. `sources` names those that it takes, for the help.
void add_run_options(CLI::App& command, RunArguments& arguments, const std::string& sources);

/// A source that is open and ready, and what it was opened with.
struct OpenedRun {
  Rig rig;                          ///< with the command line's settings put over the file's
  std::unique_ptr<Scene> scene;     ///< only for sim: the truth; outlives the input
  std::unique_ptr<BoardRun> board;  ///< only of live cameras, if there is one; outlives the input
  std::unique_ptr<TickInput> input;
  std::vector<std::string> notes;  ///< what was chosen or done without, for the person at the terminal
};

/// Opens the source, makes the detector and its limit images. `rig_needed`: without a rig file only sim has
/// one; detect works without. Throws UsageError, Error, gpu::Error.
/// `real_time`: what capturing threads enter; nullptr: nothing. It must outlive the input.
OpenedRun open_run(const RunArguments& arguments, bool rig_needed, RealTime* real_time = nullptr);

}  // namespace glint::apps
