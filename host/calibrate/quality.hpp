// SPDX-License-Identifier: MIT
// How good a calibration is, in figures: what the report shows and the verdict is made from.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint {

/// Of absolute values; all 0 where nothing was counted.
struct ErrorSummary {
  std::uint64_t count = 0;
  double mean = 0.0, rms = 0.0, p50 = 0.0, p95 = 0.0, max = 0.0;
};
/// Reorders `absolute_values`.
ErrorSummary summarise(std::vector<double>& absolute_values);

/// One sighting after the solution. Measured minus predicted, raw pixels.
struct PixelResidual {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  Eigen::Vector2d residual_px = Eigen::Vector2d::Zero();
  std::uint64_t tick = 0;
  std::uint32_t point = 0;
  bool held_out = false;  ///< the solution did not use its tick
  bool outlier = false;   ///< left out of the last solution because it fitted far too badly
};

struct CameraQuality {
  std::string name;
  ErrorSummary fit_px;       ///< of what the solution used
  ErrorSummary held_out_px;  ///< of points triangulated from the held-out ticks with the solution
  std::uint64_t outliers = 0;
  std::vector<PixelResidual> residuals;
};

/// A known distance on the target, measured by triangulating both ends in the held-out ticks alone.
struct LengthQuality {
  std::uint32_t point_a = 0, point_b = 0;
  double true_m = 0.0;
  double mean_m = 0.0, sd_m = 0.0;   ///< of the measured lengths
  ErrorSummary error_m;              ///< of |measured - true|
  std::vector<double> measured_m{};  ///< each of them
};

/// Of the estimated parameters, camera by camera: rotation (3), translation (3) and, where `intrinsics` says
/// so, fx fy cx cy k1 k2 p1 p2 k3 (9). camera_from_world is perturbed to exp(rotation) * R, t + translation.
/// The gauge is that of an alignment on the camera positions (the world moves and turns with them, its scale
/// is the target's).
struct CalibrationUncertainty {
  bool intrinsics = false;
  Eigen::MatrixXd covariance;  ///< empty: unknown
  double sigma_px = 0.0;       ///< standard deviation, per axis, of a sighting, from the residuals
};

enum class Verdict : std::uint8_t { Excellent, Good, Poor, Refuse };

struct CalibrationQuality {
  std::vector<CameraQuality> cameras;  ///< in the calibration's order
  std::vector<LengthQuality> lengths;  ///< empty: the target has no known distance
  std::uint64_t ticks_used = 0, ticks_held_out = 0;
  std::uint64_t sightings_used = 0, sightings_held_out = 0, outliers = 0;
  double fit_rms_px = 0.0;  ///< of all cameras together
  double held_out_rms_px = 0.0;
};

}  // namespace glint
