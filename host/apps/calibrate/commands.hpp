// SPDX-License-Identifier: MIT
// What `glint calibrate` can do; each is defined in the file of its name.
#pragma once

#include <CLI/CLI.hpp>

namespace glint::apps {

void add_calibrate_board(CLI::App& calibrate);
void add_calibrate_intrinsics(CLI::App& calibrate);
void add_calibrate_extrinsics(CLI::App& calibrate);
void add_calibrate_ground(CLI::App& calibrate);
void add_calibrate_check(CLI::App& calibrate);
void add_calibrate_refine(CLI::App& calibrate);

}  // namespace glint::apps
