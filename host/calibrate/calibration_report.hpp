// SPDX-License-Identifier: MIT
// How good a calibration is, for people (one HTML page that needs nothing but itself) and for programs
// (JSON).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/camera_sd.hpp"
#include "host/calibrate/coverage.hpp"
#include "host/calibrate/expected_error.hpp"
#include "host/calibrate/quality.hpp"
#include "host/calibrate/samples.hpp"
#include "host/calibrate/verdict.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

struct CalibrationReport {
  std::string title, made_from;  ///< plain text
  TargetKind target = TargetKind::Wand;
  Calibration calibration;
  CalibrationQuality quality;
  double sigma_px = 0.0;               ///< standard deviation, per axis, of a sighting; 0: unknown
  std::vector<CameraSd> sd;            ///< one per camera, or none
  std::vector<CoverageGrid> coverage;  ///< one per camera
  Overlap overlap;
  std::vector<Eigen::Vector3d> sample_points_in_world;  ///< where the target was; thinned
  ExpectedErrorSummary expected;                        ///< at the places of the samples
  ExpectedErrorMap level, upright;                      ///< slices at the samples' median height and depth
  Judgement judgement;
  std::vector<std::string> notes;  ///< what was left out, what looks odd
};

/// Computes all that a report shows. `samples` are those that the calibration was made from (or is checked
/// with); its cameras are in the calibration's order. The world's z should point up
/// (host/calibrate/ground.hpp). `only`: as in VerdictInput.
CalibrationReport make_calibration_report(std::string title, const SampleSet& samples,
                                          const Calibration& calibration, const CalibrationQuality& quality,
                                          const CalibrationUncertainty& uncertainty,
                                          std::vector<std::string> notes,
                                          std::span<const std::uint32_t> only = {});

std::string calibration_report_html(const CalibrationReport& report);
/// Lengths in metres, pixels, radians; null for what is not known.
std::string calibration_report_json(const CalibrationReport& report);

/// Writes a page (".html", ".htm") or JSON (".json"), whole or not at all; an existing file is refused unless
/// `force`. Throws Error, for any other ending too.
void write_calibration_report(const std::filesystem::path& path, const CalibrationReport& report, bool force);

}  // namespace glint
