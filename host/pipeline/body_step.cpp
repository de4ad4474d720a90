// SPDX-License-Identifier: MIT
// Points and tracks to samples of bodies, and expected markers to predictions.
#include "host/pipeline/body_step.hpp"

#include <algorithm>

#include <Eigen/LU>

#include "host/base/error.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {
namespace {

constexpr std::size_t kSamplesReserved = 512;
// A single precision difference of variances may come out as nothing or less.
constexpr double kLeastNoise_px2 = 1e-8;

BodyTrackerOptions tracker_options(const MatchOptions& match) {
  if (match.plane_height_m)
    throw Error(
        "rigid bodies need two cameras or more: with match.plane_height_m all markers are in one plane; "
        "leave "
        "out the [[body]] sections, or the plane");
  BodyTrackerOptions options;
  options.marker_radius_m = match.marker_radius_m;
  return options;
}

}  // namespace

BodyStep::BodyStep(const Calibration& calibration, const MatchOptions& match,
                   std::span<const BodyModel> bodies)
    : cameras_(calibration.cameras.begin(), calibration.cameras.end()),
      marker_radius_m_(match.marker_radius_m),
      tracker_({bodies.begin(), bodies.end()}, tracker_options(match)) {
  for (const double sd_px : calibration_sd_px(calibration)) calibration_px2_.push_back(sd_px * sd_px);
  std::size_t markers = 0;
  for (const BodyModel& body : bodies) markers += body.markers_in_body.size();
  expected_.reserve(markers);
  samples_.reserve(kSamplesReserved);
  views_.reserve(kSamplesReserved * cameras_.size());
  bodies_.reserve(bodies.size());
}

// A body that may be another one, or that is itself guessed, would only spread its error to the tracks.
bool BodyStep::advises(std::uint32_t body) const noexcept {
  const auto found = std::find_if(bodies_.begin(), bodies_.end(),
                                  [body](const TrackedBody& shown) { return shown.body == body; });
  return found != bodies_.end() && found->kind == BodyKind::Measured && !found->ambiguous;
}

// Sum over the axes of what errors of the calibration make of a position that all cameras measure.
double BodyStep::calibration_variance_m2(const Eigen::Vector3d& position_in_world) const noexcept {
  Eigen::Matrix3d information = Eigen::Matrix3d::Identity();  // a metre is as good as nothing
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> by_position;
    if (!project_pinhole(cameras_[camera], position_in_world, pixel, by_position)) continue;
    if (calibration_px2_[camera] <= 0.0) return 0.0;
    information += by_position.transpose() * by_position / calibration_px2_[camera];
  }
  return information.inverse().trace();
}

void BodyStep::predict(Timestamp exposed, std::span<Prediction> predictions) {
  tracker_.predict(exposed, expected_);
  for (const ExpectedMarker& marker : expected_) {
    if (marker.track == TrackId{} || !advises(marker.body)) continue;
    const auto found = std::lower_bound(
        predictions.begin(), predictions.end(), marker.track,
        [](const Prediction& p, TrackId wanted) { return number(p.track) < number(wanted); });
    if (found == predictions.end() || found->track != marker.track) continue;
    // The track has learnt how the calibration errs where its own position is, not the body's.
    const double of_track = found->covariance_m2.trace(), of_body = marker.covariance_m2.trace();
    if (!(of_body < of_track) || !(of_body + calibration_variance_m2(marker.position_in_world) < of_track))
      continue;
    found->position_in_world = marker.position_in_world;
    found->covariance_m2 = marker.covariance_m2;
    found->mode_count = 0;
    found->bias = {};
  }
}

// The matcher may have placed a blob better than by its centroid: where it was placed is where the point is
// seen and what it is off by.
void BodyStep::add_views(const Point& point) {
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    if (point.blob_of_camera[camera] < 0) continue;
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> by_position;
    if (!project_outline(cameras_[camera], point.position_in_world, marker_radius_m_, pixel, by_position))
      continue;
    pixel += point.residual_px[camera].cast<double>();
    const CameraCalibration& c = cameras_[camera].calibration();
    const double variance_px2 =
        std::max(kLeastNoise_px2, static_cast<double>(point.noise_px2[camera])) + calibration_px2_[camera];
    views_.push_back({&cameras_[camera],
                      {(pixel.x() - c.cx_px) / c.fx_px, (pixel.y() - c.cy_px) / c.fy_px},
                      variance_px2 * Eigen::Matrix2d::Identity()});
  }
}

void BodyStep::update(std::span<const Point> points, std::span<const TrackedPoint> tracked) {
  samples_.clear();
  views_.clear();
  views_.reserve(tracked.size() * cameras_.size());  // samples borrow from it
  for (const TrackedPoint& row : tracked) {
    if (row.kind == SampleKind::Predicted || row.point == kNoPoint) continue;
    const Point& point = points[row.point];
    const std::size_t first = views_.size();
    add_views(point);
    const std::span<const Observation> views(views_.data() + first, views_.size() - first);
    // What one camera saw is somewhere on a ray, and the track knows best where.
    if (row.kind == SampleKind::Measured)
      samples_.push_back(
          {row.id, point.position_in_world, point.covariance_m2 + point.calibration_covariance_m2, views});
    else
      samples_.push_back({row.id, row.position_in_world, row.covariance_m2, views});
  }
  tracker_.update(samples_, bodies_, counters_);
}

}  // namespace glint
