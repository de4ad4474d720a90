// SPDX-License-Identifier: MIT
// `glint calibrate`: from lenses and places unknown to a calibration file, and whether that still holds.
#include "host/apps/calibrate/commands.hpp"
#include "host/apps/commands.hpp"

namespace glint::apps {

void add_calibrate(CLI::App& app) {
  CLI::App* calibrate = app.add_subcommand("calibrate", "Calibrate lenses and places of the cameras");
  calibrate->require_subcommand(1);
  add_calibrate_board(*calibrate);
  add_calibrate_intrinsics(*calibrate);
  add_calibrate_extrinsics(*calibrate);
  add_calibrate_ground(*calibrate);
  add_calibrate_check(*calibrate);
  add_calibrate_refine(*calibrate);
}

}  // namespace glint::apps
