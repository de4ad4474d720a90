// SPDX-License-Identifier: MIT
// Computes what a report shows, and puts the file in place.
#include "host/calibrate/calibration_report.hpp"

#include <algorithm>
#include <utility>

#include "host/base/error.hpp"
#include "host/calibrate/report/extent.hpp"
#include "host/calibrate/sample_points.hpp"
#include "host/files/text_file.hpp"

namespace glint {

CalibrationReport make_calibration_report(std::string title, const SampleSet& samples,
                                          const Calibration& calibration, const CalibrationQuality& quality,
                                          const CalibrationUncertainty& uncertainty,
                                          std::vector<std::string> notes,
                                          std::span<const std::uint32_t> only) {
  CalibrationReport report;
  report.title = std::move(title);
  report.made_from = calibration.made_from;
  report.target = samples.target.kind;
  report.calibration = calibration;
  report.quality = quality;
  report.sigma_px = uncertainty.sigma_px;
  report.sd = camera_sd(calibration, uncertainty);
  report.coverage = coverage_of(samples);
  report.overlap = overlap_of(samples);
  report.sample_points_in_world = sample_points(calibration, samples);
  report.notes = std::move(notes);

  const ExpectedError expected(calibration, uncertainty, samples.target.marker_radius_m);
  report.expected = expected_error_at(expected, report.sample_points_in_world);
  const ReportExtent extent = report_extent(calibration, report.sample_points_in_world);
  const double step_m = (extent.high_in_world - extent.low_in_world).maxCoeff() / 72.0;
  report.level = expected_error_map(
      expected, horizontal_slice(extent.low_in_world, extent.high_in_world, extent.middle_in_world.z()),
      step_m);
  report.upright = expected_error_map(
      expected, vertical_slice(extent.low_in_world, extent.high_in_world, extent.middle_in_world.y()),
      step_m);

  VerdictInput input;
  input.quality = &report.quality;
  input.coverage = report.coverage;
  input.overlap = &report.overlap;
  if (expected.knows_calibration() && report.expected.total_m.count > 0) input.expected = report.expected;
  input.target = report.target;
  input.only = only;
  report.judgement = judge(input);
  return report;
}

void write_calibration_report(const std::filesystem::path& path, const CalibrationReport& report,
                              bool force) {
  const std::string ending = path.extension().string();
  if (ending == ".json") {
    write_text_file(path, calibration_report_json(report), force);
  } else if (ending == ".html" || ending == ".htm") {
    write_text_file(path, calibration_report_html(report), force);
  } else {
    throw Error(path.string() + ": a report's name ends in .html or .json");
  }
}

}  // namespace glint
