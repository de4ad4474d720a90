// SPDX-License-Identifier: MIT
// Where all cameras of a rig stand, from samples of a target that was moved through the volume.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/calibrate/bundle.hpp"
#include "host/calibrate/quality.hpp"
#include "host/calibrate/rig_start.hpp"
#include "host/calibrate/sample_timing.hpp"
#include "host/calibrate/samples.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// What sets the scale of a lone marker's samples.
struct KnownCameraDistance {
  std::uint32_t a = 0, b = 0;  ///< cameras
  double distance_m = 0.0;     ///< between the centres of their lenses
};

struct ExtrinsicsOptions {
  bool refine_intrinsics = false;  ///< within their intrinsics_sd; without those, within kUnknownIntrinsicsSd
  bool hold_out = true;            ///< keep every fifth block of ticks to judge by
  double length_sd_m = 0.0002;     ///< of a wand's distances: how far it bends
  std::optional<KnownCameraDistance>
      camera_distance;  ///< needed for a lone marker, refused for other targets
  /// Cameras to place anew; the others stay as they are in `cameras`. Empty: all, and the world is then the
  /// frame of the first camera.
  std::vector<std::uint32_t> only;
  bool schur = true;  ///< false: Ceres' default linear solver, for comparison
};

/// Of intrinsics that a data sheet or another tool gave: focal length and centre relative to the image's
/// width.
struct UnknownIntrinsicsSd {
  double focal = 0.01, centre = 0.01, k1 = 0.05, k2 = 0.05, p = 0.002, k3 = 0.0;
};

struct ExtrinsicsResult {
  Calibration calibration;
  CalibrationQuality quality;
  CalibrationUncertainty uncertainty;
  SampleSet samples;              ///< as given, but the ends of a wand of two numbered alike within a tick
  std::vector<CameraPair> pairs;  ///< as far as they were looked at: none with `only`
  std::optional<SampleTiming> timing;
  BundleSummary adjustment;        ///< the last one
  std::vector<std::string> notes;  ///< what was left out, and what looks odd
};

/// `cameras` has the samples' cameras in their order with their intrinsics (and poses, where `only` keeps
/// them). Throws Error that says what is wrong with the samples and what to do.
ExtrinsicsResult solve_extrinsics(const SampleSet& samples, const std::vector<CameraCalibration>& cameras,
                                  const ExtrinsicsOptions& options);

}  // namespace glint
