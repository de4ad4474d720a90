// SPDX-License-Identifier: MIT
#include "host/calibrate/evaluate.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/calibrate/sighting_model.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {
namespace {

/// Errors of one kind, of the solution's own ticks and of those held out.
struct Errors {
  std::vector<double> fit, held_out;
  void add(double value, bool out) { (out ? held_out : fit).push_back(value); }
};

struct Lengths {
  double true_m;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> between;  // pairs of points that far apart
  std::vector<double> measured_m;
};

class Evaluation {
 public:
  Evaluation(const Calibration& calibration, const SampleSet& samples, bool hold_out,
             const std::vector<std::uint8_t>& outlier)
      : samples_(samples),
        hold_out_(hold_out),
        outlier_(outlier),
        cameras_(calibration.cameras.begin(), calibration.cameras.end()),
        errors_(cameras_.size()) {
    for (const CameraCalibration& camera : calibration.cameras) {
      quality_.cameras.push_back({camera.name, {}, {}, 0, {}});
      intrinsics_.push_back(intrinsics_of(camera));
    }
    const std::vector<Eigen::Vector3d>& points = samples.target.points_in_target;
    if (samples.target.kind == TargetKind::Wand) {
      for (std::uint32_t a = 0; a < points.size(); ++a)
        for (std::uint32_t b = a + 1; b < points.size(); ++b)
          lengths_.push_back({(points[b] - points[a]).norm(), {{a, b}}, {}});
    } else if (samples.target.kind == TargetKind::Board) {
      add_board_lengths(points);
    }
  }

  CalibrationQuality run() {
    const std::vector<SampleTick> ticks = ticks_of(samples_);
    for (std::size_t t = 0; t < ticks.size(); ++t) add_tick(ticks[t], hold_out_ && held_out(t));
    finish();
    return std::move(quality_);
  }

 private:
  /// Of a board, neighbours along its rows: all the same distance.
  void add_board_lengths(const std::vector<Eigen::Vector3d>& points) {
    if (points.size() < 2) return;
    Lengths neighbours{(points[1] - points[0]).norm(), {}, {}};
    for (std::uint32_t a = 0; a + 1 < points.size(); ++a)
      if (std::abs((points[a + 1] - points[a]).norm() - neighbours.true_m) < 1e-9)
        neighbours.between.emplace_back(a, a + 1);
    lengths_.push_back(std::move(neighbours));
  }

  void add_tick(const SampleTick& tick, bool out) {
    std::vector<std::optional<Eigen::Vector3d>> points(samples_.target.points_in_target.size());
    bool used = false;
    for (std::uint32_t point = 0; point < points.size(); ++point) {
      points[point] = add_point(tick, point, out);
      used |= points[point].has_value();
    }
    if (used) ++(out ? quality_.ticks_held_out : quality_.ticks_used);
    if (hold_out_ && !out) return;
    for (Lengths& length : lengths_)
      for (const auto& [a, b] : length.between)
        if (points[a] && points[b]) length.measured_m.push_back((*points[b] - *points[a]).norm());
  }

  std::optional<Eigen::Vector3d> add_point(const SampleTick& tick, std::uint32_t point, bool out) {
    const double radius_m = samples_.target.marker_radius_m;
    std::vector<Observation> views;
    std::vector<const Sighting*> used, left_out;
    for (const Sighting& s : tick.sightings) {
      if (s.point != point) continue;
      const auto place = static_cast<std::size_t>(&s - samples_.sightings.data());
      if (!outlier_.empty() && outlier_[place] != 0) {
        ++quality_.cameras[s.camera].outliers;
        left_out.push_back(&s);
        continue;
      }
      const auto plane = cameras_[s.camera].undistort(s.pixel);
      if (!plane) continue;
      views.push_back({&cameras_[s.camera], *plane, Eigen::Matrix2d::Identity()});
      used.push_back(&s);
    }
    TriangulateOptions options;
    options.marker_radius_m = radius_m;
    const auto found = triangulate(views, options);
    if (!found) return std::nullopt;
    for (const Sighting* s : left_out) add_residual(*s, found->position_in_world, out, true);
    for (const Sighting* s : used) add_residual(*s, found->position_in_world, out, false);
    return found->position_in_world;
  }

  void add_residual(const Sighting& s, const Eigen::Vector3d& point_in_world, bool out, bool outlier) {
    PredictedSighting predicted;
    if (!predict_sighting(intrinsics_[s.camera].data(), cameras_[s.camera].in_camera(point_in_world),
                          samples_.target.marker_radius_m, predicted))
      return;
    CameraQuality& camera = quality_.cameras[s.camera];
    const Eigen::Vector2d residual = s.pixel - predicted.pixel;
    camera.residuals.push_back({s.pixel, residual, s.tick, s.point, out, outlier});
    if (!outlier) errors_[s.camera].add(residual.norm(), out);
  }

  void finish() {
    Errors all;
    for (std::size_t c = 0; c < cameras_.size(); ++c) {
      all.fit.insert(all.fit.end(), errors_[c].fit.begin(), errors_[c].fit.end());
      all.held_out.insert(all.held_out.end(), errors_[c].held_out.begin(), errors_[c].held_out.end());
      quality_.cameras[c].fit_px = summarise(errors_[c].fit);
      quality_.cameras[c].held_out_px = summarise(errors_[c].held_out);
      quality_.outliers += quality_.cameras[c].outliers;
    }
    const ErrorSummary fit = summarise(all.fit), out = summarise(all.held_out);
    quality_.sightings_used = fit.count, quality_.fit_rms_px = fit.rms;
    quality_.sightings_held_out = out.count, quality_.held_out_rms_px = out.rms;
    for (Lengths& length : lengths_)
      if (!length.measured_m.empty()) quality_.lengths.push_back(quality_of(length));
  }

  static LengthQuality quality_of(const Lengths& length) {
    LengthQuality quality;
    quality.point_a = length.between.front().first, quality.point_b = length.between.front().second;
    quality.true_m = length.true_m;
    const auto count = static_cast<double>(length.measured_m.size());
    std::vector<double> errors;
    for (double measured : length.measured_m) {
      quality.mean_m += measured / count;
      errors.push_back(std::abs(measured - length.true_m));
    }
    double squares = 0.0;
    for (double measured : length.measured_m)
      squares += (measured - quality.mean_m) * (measured - quality.mean_m);
    quality.sd_m = std::sqrt(squares / std::max(1.0, count - 1.0));
    quality.error_m = summarise(errors);
    quality.measured_m = length.measured_m;
    return quality;
  }

  const SampleSet& samples_;
  bool hold_out_;
  const std::vector<std::uint8_t>& outlier_;
  std::vector<Camera> cameras_;
  std::vector<Intrinsics> intrinsics_;
  std::vector<Errors> errors_;
  std::vector<Lengths> lengths_;
  CalibrationQuality quality_;
};

}  // namespace

ErrorSummary summarise(std::vector<double>& values) {
  ErrorSummary summary;
  if (values.empty()) return summary;
  std::sort(values.begin(), values.end());
  summary.count = values.size();
  const auto count = static_cast<double>(values.size());
  double squares = 0.0;
  for (double value : values) {
    summary.mean += value / count;
    squares += value * value;
  }
  summary.rms = std::sqrt(squares / count);
  const auto quantile = [&](double share) {
    return values[static_cast<std::size_t>(share * (count - 1.0) + 0.5)];
  };
  summary.p50 = quantile(0.50);
  summary.p95 = quantile(0.95);
  summary.max = values.back();
  return summary;
}

CalibrationQuality evaluate(const Calibration& calibration, const SampleSet& samples, bool hold_out,
                            const std::vector<std::uint8_t>& outlier) {
  return Evaluation(calibration, samples, hold_out, outlier).run();
}

}  // namespace glint
