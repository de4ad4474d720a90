// SPDX-License-Identifier: MIT
// The figures of a report as JSON.
#include <cmath>

#include <nlohmann/json.hpp>

#include "host/calibrate/calibration_report.hpp"

namespace glint {
namespace {

using Json = nlohmann::ordered_json;

/// null for what is no number.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json vector(const Eigen::Vector3d& v) { return {number(v.x()), number(v.y()), number(v.z())}; }

Json summary(const ErrorSummary& s) {
  return {{"count", s.count},     {"mean", number(s.mean)}, {"rms", number(s.rms)},
          {"p50", number(s.p50)}, {"p95", number(s.p95)},   {"max", number(s.max)}};
}

Json map(const ExpectedErrorMap& m) {
  Json values = Json::array();
  for (const double value : m.error_m) values.push_back(number(value));
  return {{"corner_in_world_m", vector(m.slice.corner_in_world)},
          {"along", vector(m.slice.along)},
          {"up", vector(m.slice.up)},
          {"step_m", m.step_m},
          {"columns", m.columns},
          {"rows", m.rows},
          {"rms_m", values}};
}

Json camera(const CalibrationReport& report, std::size_t i) {
  const CameraCalibration& c = report.calibration.cameras[i];
  Json json{{"name", c.name}, {"position_in_world_m", vector(c.world_from_camera.translation)}};
  if (i < report.sd.size()) {
    json["position_sd_m"] = vector(report.sd[i].position_m);
    json["orientation_sd_rad"] = number(report.sd[i].orientation_rad);
    json["intrinsics_sd"] = report.sd[i].intrinsics;
  }
  if (i < report.quality.cameras.size()) {
    const CameraQuality& q = report.quality.cameras[i];
    json["fit_px"] = summary(q.fit_px);
    json["held_out_px"] = summary(q.held_out_px);
    json["outliers"] = q.outliers;
  }
  if (i < report.coverage.size()) {
    Json rows = Json::array();
    for (std::size_t row = 0; row < CoverageGrid::kRows; ++row) {
      Json cells = Json::array();
      for (std::size_t column = 0; column < CoverageGrid::kColumns; ++column)
        cells.push_back(report.coverage[i].count(column, row));
      rows.push_back(cells);
    }
    json["covered"] = report.coverage[i].share();
    json["samples_in_cells"] = rows;
  }
  return json;
}

Json judgement(const Judgement& j) {
  Json criteria = Json::array();
  for (const Criterion& c : j.criteria) {
    criteria.push_back({{"name", c.name},
                        {"measured", c.measured},
                        {"level", word_of(c.level)},
                        {"excellent", c.limits[0]},
                        {"good", c.limits[1]},
                        {"poor", c.limits[2]},
                        {"remedy", c.remedy}});
  }
  return criteria;
}

}  // namespace

std::string calibration_report_json(const CalibrationReport& report) {
  const CalibrationQuality& q = report.quality;
  Json json{{"kind", "glint calibration report"},
            {"format", 1},
            {"title", report.title},
            {"made_from", report.made_from},
            {"made_at", report.calibration.made_at},
            {"verdict", word_of(report.judgement.verdict)},
            {"rule", report.judgement.rule},
            {"criteria", judgement(report.judgement)},
            {"ticks_used", q.ticks_used},
            {"ticks_held_out", q.ticks_held_out},
            {"sightings_used", q.sightings_used},
            {"sightings_held_out", q.sightings_held_out},
            {"outliers", q.outliers},
            {"fit_rms_px", number(q.fit_rms_px)},
            {"held_out_rms_px", number(q.held_out_rms_px)},
            {"sighting_sd_px", number(report.sigma_px)}};
  Json cameras = Json::array(), lengths = Json::array(), overlap = Json::array();
  for (std::size_t i = 0; i < report.calibration.cameras.size(); ++i) cameras.push_back(camera(report, i));
  for (const LengthQuality& l : q.lengths) {
    lengths.push_back({{"points", {l.point_a, l.point_b}},
                       {"true_m", l.true_m},
                       {"mean_m", number(l.mean_m)},
                       {"sd_m", number(l.sd_m)},
                       {"absolute_error_m", summary(l.error_m)}});
  }
  for (std::size_t a = 0; a < report.overlap.cameras(); ++a) {
    Json row = Json::array();
    for (std::size_t b = 0; b < report.overlap.cameras(); ++b) row.push_back(report.overlap.ticks(a, b));
    overlap.push_back(row);
  }
  json["cameras"] = cameras;
  json["lengths"] = lengths;
  json["common_ticks"] = overlap;
  json["expected_error"] = {{"places", report.expected.places},
                            {"total_m", summary(report.expected.total_m)},
                            {"by_calibration_m", summary(report.expected.calibration_m)},
                            {"by_noise_m", summary(report.expected.noise_m)},
                            {"level_slice", map(report.level)},
                            {"upright_slice", map(report.upright)}};
  json["notes"] = report.notes;
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace glint
