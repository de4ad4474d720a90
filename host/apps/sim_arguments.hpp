// SPDX-License-Identifier: MIT
// The simulated rig's options on the command line, for every command that simulates.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/geometry/camera.hpp"
#include "host/sim/options.hpp"

namespace glint::apps {

struct SimArguments {
  SimOptions options;
  std::string motion;                 ///< thrown, tumbling, crossing, pairs; empty: thrown, or a waved wand
  std::vector<double> wave_m;         ///< as SimOptions::wand_m
  std::string bump;                   ///< CAMERA:TICK:DEGREES
  std::string slip;                   ///< CAMERA:TICK:PULSES
  std::string swap;                   ///< CAMERA:OTHER:TICK
  std::string delay;                  ///< CAMERA:TICK:MS
  std::vector<std::string> off;       ///< CAMERA:TICK:TICKS each
  double calibration_error_px = 0.0;  ///< of the calibration that the tracker gets; the rig stands as it does
};

void add_sim_options(CLI::App& command, SimArguments& arguments);

/// Throws UsageError that lists everything that is out of range.
SimOptions checked_sim_options(const SimArguments& arguments);

/// What a tracker is told about a rig that stands as `exact` says.
Calibration told_calibration(const SimArguments& arguments, const Calibration& exact);

}  // namespace glint::apps
