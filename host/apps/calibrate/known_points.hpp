// SPDX-License-Identifier: MIT
// Where cameras stand, each by itself, from points whose places are known: a ceiling camera over a marked
// floor, say.
#pragma once

#include <string>

namespace glint::apps {

struct KnownPoints {
  std::string points;    ///< CSV with camera,x_m,y_m,z_m,x_px,y_px
  std::string rig_file;  ///< has the intrinsics
  std::string output;
  bool force = false;
};

/// Writes the calibration of the cameras that the points name. Throws Error, UsageError.
void place_by_known_points(const KnownPoints& arguments);

}  // namespace glint::apps
