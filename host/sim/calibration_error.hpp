// SPDX-License-Identifier: MIT
// A calibration that is a little wrong, as all are.
#pragma once

#include <cstdint>

#include "host/geometry/camera.hpp"

namespace glint {

/// Every camera turned about its three axes and shifted, at random, so that turning alone and shifting alone
/// would move the images equally far. Together they move them by `error_px`: root mean square of the length
/// of the shift, over a grid of points of the simulated volume that the camera sees; the cameras' rms_px say
/// so. With 0 the calibration comes back as it was.
Calibration disturbed(const Calibration& exact, double error_px, std::uint64_t seed);

}  // namespace glint
