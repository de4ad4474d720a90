// SPDX-License-Identifier: MIT
// Propagates the covariance of the cameras and the noise of the sightings to a triangulated point.
#include "host/calibrate/expected_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "host/base/check.hpp"
#include "host/geometry/rotation.hpp"

namespace glint {
namespace {

constexpr std::size_t kMostCells = 20'000;
constexpr double kLeastSine = 0.02;  // of the angle between two rays, as the triangulation demands

}  // namespace

double PointError::rms_m() const { return std::sqrt(covariance_m2().trace()); }

ExpectedError::ExpectedError(const Calibration& calibration, const CalibrationUncertainty& uncertainty,
                             double marker_radius_m)
    : covariance_(uncertainty.covariance),
      block_(uncertainty.intrinsics ? 15 : 6),
      sigma_px_(uncertainty.sigma_px),
      marker_radius_m_(marker_radius_m) {
  for (const CameraCalibration& camera : calibration.cameras) {
    cameras_.emplace_back(camera);
    intrinsics_.push_back(intrinsics_of(camera));
  }
  const auto wanted = block_ * static_cast<Eigen::Index>(cameras_.size());
  GLINT_CHECK(covariance_.size() == 0 || (covariance_.rows() == wanted && covariance_.cols() == wanted));
}

std::optional<ExpectedError::View> ExpectedError::view(std::size_t camera,
                                                       const Eigen::Vector3d& point_in_world) const {
  const Camera& seen_by = cameras_[camera];
  const Eigen::Vector3d in_camera = seen_by.in_camera(point_in_world);
  PredictedSighting sighting;
  if (!predict_sighting(intrinsics_[camera].data(), in_camera, marker_radius_m_, sighting))
    return std::nullopt;
  if (!seen_by.inside(sighting.pixel)) return std::nullopt;
  // Far outside the image the lens model folds over and brings points back into it.
  const auto back = seen_by.undistort(sighting.pixel);
  if (!back || (*back - in_camera.hnormalized()).norm() > 0.01) return std::nullopt;

  View view;
  view.camera = camera;
  const Eigen::Matrix3d& rotation = seen_by.camera_from_world_rotation();
  view.by_point = sighting.by_point_in_camera * rotation;
  // exp(w) R X + t changes by w x (R X).
  view.by_camera.leftCols<3>() = sighting.by_point_in_camera * -cross_matrix(rotation * point_in_world);
  view.by_camera.middleCols<3>(3) = sighting.by_point_in_camera;
  view.by_camera.rightCols<9>() = sighting.by_intrinsics;
  return view;
}

std::optional<PointError> ExpectedError::at(const Eigen::Vector3d& point_in_world) const {
  std::vector<View> views;
  std::vector<Eigen::Vector3d> rays;
  for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
    if (auto seen = view(camera, point_in_world)) {
      views.push_back(*seen);
      rays.push_back((point_in_world - cameras_[camera].position_in_world()).normalized());
    }
  }
  double widest_sine = 0.0;
  for (std::size_t i = 0; i < rays.size(); ++i)
    for (std::size_t j = i + 1; j < rays.size(); ++j)
      widest_sine = std::max(widest_sine, rays[i].cross(rays[j]).norm());
  if (widest_sine < kLeastSine) return std::nullopt;

  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (const View& v : views) information += v.by_point.transpose() * v.by_point;
  const Eigen::Matrix3d inverse = information.ldlt().solve(Eigen::Matrix3d::Identity());
  if (!inverse.allFinite()) return std::nullopt;

  PointError error;
  error.views = static_cast<unsigned>(views.size());
  error.noise_m2 = sigma_px_ * sigma_px_ * inverse;
  if (covariance_.size() == 0) return error;
  Eigen::Matrix3Xd by_parameters(3, block_ * static_cast<Eigen::Index>(views.size()));
  for (std::size_t i = 0; i < views.size(); ++i) {
    by_parameters.middleCols(static_cast<Eigen::Index>(i) * block_, block_) =
        inverse * views[i].by_point.transpose() * views[i].by_camera.leftCols(block_);
  }
  // Camera by camera: only the blocks of those that see the point.
  const auto part = [&](std::size_t i) {
    return by_parameters.middleCols(static_cast<Eigen::Index>(i) * block_, block_);
  };
  Eigen::Matrix<double, 3, Eigen::Dynamic, 0, 3, 15> row(3, block_);
  for (std::size_t i = 0; i < views.size(); ++i) {
    row.setZero();
    for (std::size_t j = 0; j < views.size(); ++j) {
      row.noalias() += part(j).lazyProduct(
          covariance_.block(static_cast<Eigen::Index>(views[j].camera) * block_,
                            static_cast<Eigen::Index>(views[i].camera) * block_, block_, block_));
    }
    error.calibration_m2 += row * part(i).transpose();
  }
  return error;
}

Eigen::Vector3d ExpectedErrorMap::centre_in_world(std::size_t column, std::size_t row) const {
  return slice.corner_in_world + (static_cast<double>(column) + 0.5) * step_m * slice.along +
         (static_cast<double>(row) + 0.5) * step_m * slice.up;
}

ExpectedErrorMap expected_error_map(const ExpectedError& expected, const Slice& slice, double step_m) {
  GLINT_CHECK(step_m > 0 && slice.width_m > 0 && slice.height_m > 0);
  ExpectedErrorMap map;
  map.slice = slice;
  map.step_m = std::max(step_m, std::sqrt(slice.width_m * slice.height_m / static_cast<double>(kMostCells)));
  const auto cells = [&](double extent_m) {
    return static_cast<std::size_t>(std::max(1.0, std::round(extent_m / map.step_m)));
  };
  map.columns = cells(slice.width_m);
  map.rows = cells(slice.height_m);
  map.error_m.reserve(map.columns * map.rows);
  for (std::size_t row = 0; row < map.rows; ++row) {
    for (std::size_t column = 0; column < map.columns; ++column) {
      const auto error = expected.at(map.centre_in_world(column, row));
      map.error_m.push_back(error ? error->rms_m() : std::numeric_limits<double>::quiet_NaN());
    }
  }
  return map;
}

Slice horizontal_slice(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double height_m) {
  return {{low.x(), low.y(), height_m},
          Eigen::Vector3d::UnitX(),
          Eigen::Vector3d::UnitY(),
          high.x() - low.x(),
          high.y() - low.y()};
}

Slice vertical_slice(const Eigen::Vector3d& low, const Eigen::Vector3d& high, double y_m) {
  return {{low.x(), y_m, low.z()},
          Eigen::Vector3d::UnitX(),
          Eigen::Vector3d::UnitZ(),
          high.x() - low.x(),
          high.z() - low.z()};
}

ExpectedErrorSummary expected_error_at(const ExpectedError& expected,
                                       std::span<const Eigen::Vector3d> points_in_world, std::size_t most) {
  ExpectedErrorSummary summary;
  std::vector<double> total, calibration, noise;
  const std::size_t stride =
      std::max<std::size_t>(1, points_in_world.size() / std::max<std::size_t>(1, most));
  for (std::size_t i = 0; i < points_in_world.size(); i += stride) {
    ++summary.places;
    const auto error = expected.at(points_in_world[i]);
    if (!error) continue;
    total.push_back(error->rms_m());
    calibration.push_back(std::sqrt(error->calibration_m2.trace()));
    noise.push_back(std::sqrt(error->noise_m2.trace()));
  }
  summary.total_m = summarise(total);
  summary.calibration_m = summarise(calibration);
  summary.noise_m = summarise(noise);
  return summary;
}

}  // namespace glint
