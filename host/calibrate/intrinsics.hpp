// SPDX-License-Identifier: MIT
// Focal lengths, principal point and lens of one camera, from views of a board.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "host/calibrate/board_session.hpp"
#include "host/calibrate/quality.hpp"
#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

struct IntrinsicsOptions {
  bool k3 = false;  ///< estimate k3, too: for lenses of more than 90 degrees or so; else it is 0
  /// Huber's loss, and views that fit far worse are left out. Without: plain least squares over everything,
  /// which is what OpenCV's calibrateCamera does; for comparison with it.
  bool robust = true;
};

/// One picture of the board, after the solution.
struct BoardViewResult {
  std::uint64_t tick = 0;
  std::size_t corners = 0;
  double rms_px = 0.0;    ///< as of rms_px below
  bool outlier = false;   ///< left out, because it fitted far worse than the others
  bool held_out = false;  ///< of those that judge the rest; in the end it is used, too
  Pose camera_from_target;
};

struct IntrinsicsResult {
  /// With rms_px and intrinsics_sd; its pose is that of the origin.
  CameraCalibration camera;
  std::vector<BoardViewResult> views;
  double rms_px = 0.0;           ///< sqrt(mean |measured - predicted|^2) of all corners used
  double held_out_rms_px = 0.0;  ///< likewise, of every fifth view, whose corners the lens was not fitted to;
                                 ///< 0: too few views to hold any back
  double sigma_px = 0.0;         ///< standard deviation of a corner, per axis, from what is left over
  double covered = 0.0;          ///< share of the image's cells that hold corners
  std::vector<std::string> advice;  ///< what would make it better; empty: nothing
  Verdict verdict = Verdict::Refuse;
  std::string rule;  ///< what that word means, in figures
};

/// Calibrates one camera of a set of board samples. Starts from Zhang's closed form, then least squares in
/// the image with a Huber loss; views that fit far worse than the others are left out and named. Throws Error
/// that begins with the camera's name and says why it cannot be done and what to do: too few views, all of
/// them parallel, the board too small, views that contradict one another.
IntrinsicsResult calibrate_intrinsics(const SampleSet& samples, std::uint32_t camera,
                                      const IntrinsicsOptions& options);

}  // namespace glint
