// SPDX-License-Identifier: MIT
// From pictures of a board to calibration samples.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/apps/live_cameras.hpp"
#include "host/apps/sim_arguments.hpp"
#include "host/calibrate/samples.hpp"
#include "host/target/board_finder.hpp"

namespace glint::apps {

struct BoardSource {
  std::string source;  ///< images:LOCATION or a path, v4l2:DEVICE,..., sim
  BoardSpec board;
  BoardFinderOptions finder;
  Rig rig;  ///< v4l2: which device is which camera; may be empty
  LiveArguments live;
  SimArguments sim;
  std::size_t sim_views = 40;   ///< of each simulated camera
  std::size_t most_views = 80;  ///< kept of each camera; more take longer and tell little
  bool together = false;        ///< only ticks at which two cameras see it, and then all that do
  bool still =
      false;  ///< it lies still: every tick with it, whether it differs or not, until one camera is full
  bool quiet = false;
};

struct BoardSamples {
  SampleSet samples;  ///< of each camera only views that differ from its others, but for BoardSource::still
  std::vector<std::string> notes;  ///< one line a camera: pictures, views found and kept; why none, if so
  Calibration truth;               ///< sim only
};

/// Reads the source to its end; of live cameras until every one has enough, or Ctrl-C, and tells meanwhile
/// what is missing. Throws Error, UsageError: no OpenCV; pictures damaged or of different sizes.
BoardSamples collect_board_samples(const BoardSource& source);

}  // namespace glint::apps
