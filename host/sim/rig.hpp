// SPDX-License-Identifier: MIT
// Where the simulated cameras stand and which lenses they have.
#pragma once

#include "host/geometry/camera.hpp"
#include "host/sim/options.hpp"

namespace glint {

/// Exact calibration of the simulated rig: cameras "cam1".."camN" on the corners of 5 m x 5 m (more than
/// four: on the circle through the corners), 2.4 m high, looking at the middle of the volume, everything 1-5
/// cm out of line.
Calibration sim_calibration(const SimOptions& options);

}  // namespace glint
