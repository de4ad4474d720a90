// SPDX-License-Identifier: MIT
// How wrong a triangulated point is expected to be, anywhere in the volume.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/quality.hpp"
#include "host/calibrate/sighting_model.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

/// Of one point. The two parts are independent and add up.
struct PointError {
  Eigen::Matrix3d calibration_m2 =
      Eigen::Matrix3d::Zero();  ///< covariance from the cameras' uncertain parameters
  Eigen::Matrix3d noise_m2 =
      Eigen::Matrix3d::Zero();  ///< covariance from the noise of one exposure's sightings
  unsigned views = 0;           ///< cameras that see it

  Eigen::Matrix3d covariance_m2() const { return calibration_m2 + noise_m2; }
  /// Root of the mean squared distance from the truth.
  double rms_m() const;
};

/// First-order propagation. Least squares over the cameras that see a point moves it by
///     dX = (sum J'J)^-1 sum J' (e - C dc),
/// with J and C the derivatives of the pixel by the point and by the camera's parameters, e the noise of the
/// sighting and dc the error of the parameters (Foerstner and Wrobel, Photogrammetric Computer Vision,
/// 2016, 2.7 and 4.2.3). In the gauge of CalibrationUncertainty, so it is the error after the best alignment
/// with the truth.
class ExpectedError {
 public:
  /// Copies what it needs. Without a covariance only the noise counts.
  ExpectedError(const Calibration& calibration, const CalibrationUncertainty& uncertainty,
                double marker_radius_m = 0.0);

  /// Nothing where fewer than two cameras see the point, or all of them along nearly the same line.
  std::optional<PointError> at(const Eigen::Vector3d& point_in_world) const;
  bool knows_calibration() const noexcept { return covariance_.size() > 0; }

 private:
  struct View {
    std::size_t camera = 0;
    Eigen::Matrix<double, 2, 3> by_point;
    Eigen::Matrix<double, 2, 15> by_camera;  // rotation, translation, intrinsics
  };
  std::optional<View> view(std::size_t camera, const Eigen::Vector3d& point_in_world) const;

  std::vector<Camera> cameras_;
  std::vector<Intrinsics> intrinsics_;
  Eigen::MatrixXd covariance_;
  Eigen::Index block_ = 6;  // parameters per camera
  double sigma_px_ = 0.0, marker_radius_m_ = 0.0;
};

/// A flat piece of the volume.
struct Slice {
  Eigen::Vector3d corner_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d along = Eigen::Vector3d::UnitX(),
                  up = Eigen::Vector3d::UnitY();  ///< unit vectors of its sides
  double width_m = 1.0, height_m = 1.0;           ///< along, up
};

/// Expected rms error over a slice. Cells are squares of about `step_m`; values are those at their centres.
struct ExpectedErrorMap {
  Slice slice;
  std::size_t columns = 0, rows = 0;
  double step_m = 0.0;
  std::vector<double> error_m;  ///< row by row from the corner; NaN: fewer than two cameras see it

  double at(std::size_t column, std::size_t row) const { return error_m[row * columns + column]; }
  Eigen::Vector3d centre_in_world(std::size_t column, std::size_t row) const;
};

/// The slice is cut into as many whole cells as fit best; the last ones may reach half a cell beyond it.
/// `step_m` is enlarged until there are at most 20,000.
ExpectedErrorMap expected_error_map(const ExpectedError& expected, const Slice& slice, double step_m);

/// Parallel to the floor, over all that lies between low and high in x and y.
Slice horizontal_slice(const Eigen::Vector3d& low_in_world, const Eigen::Vector3d& high_in_world,
                       double height_m);
/// Upright, along x, at this y.
Slice vertical_slice(const Eigen::Vector3d& low_in_world, const Eigen::Vector3d& high_in_world, double y_m);

/// Rms errors at a number of places.
struct ExpectedErrorSummary {
  ErrorSummary total_m, calibration_m, noise_m;  ///< all counted: seen by two cameras at least
  std::uint64_t places = 0;                      ///< looked at
};
/// At places where the target was, say. At most about `most` of the points are looked at, evenly.
ExpectedErrorSummary expected_error_at(const ExpectedError& expected,
                                       std::span<const Eigen::Vector3d> points_in_world,
                                       std::size_t most = 500);

}  // namespace glint
