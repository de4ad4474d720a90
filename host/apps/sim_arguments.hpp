// SPDX-License-Identifier: MIT
// The simulated rig's options on the command line, for every command that simulates.
#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "host/sim/options.hpp"

namespace glint::apps {

struct SimArguments {
  SimOptions options;
  std::string bump;            ///< CAMERA:TICK:DEGREES
  std::vector<double> wave_m;  ///< as SimOptions::wand_m
  std::string slip;            ///< CAMERA:TICK:PULSES
  std::string swap;            ///< CAMERA:OTHER:TICK
  std::string delay;           ///< CAMERA:TICK:MS
};

void add_sim_options(CLI::App& command, SimArguments& arguments);

/// Throws UsageError that lists everything that is out of range.
SimOptions checked_sim_options(const SimArguments& arguments);

}  // namespace glint::apps
