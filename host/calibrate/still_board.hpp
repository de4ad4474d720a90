// SPDX-License-Identifier: MIT
// Where a printed board lies, from pictures of all cameras of a calibrated rig.
#pragma once

#include <cstddef>

#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"
#include "host/geometry/pose.hpp"

namespace glint {

struct StillBoard {
  Pose world_from_board;
  std::size_t cameras = 0;  ///< that saw it
  double rms_px = 0.0;      ///< of the reprojection, per corner: sqrt(mean |measured - predicted|^2)
};

/// Corners are averaged over the ticks, then the pose is least squares in all images. Of the samples' cameras
/// each must be in the calibration, by name. One camera will do, but a board that is small in its image has
/// two poses that fit nearly as well. Throws Error if no camera sees the board, if it moved between ticks, or
/// if it does not fit the calibration.
StillBoard place_still_board(const SampleSet& samples, const Calibration& calibration);

}  // namespace glint
