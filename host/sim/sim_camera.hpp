// SPDX-License-Identifier: MIT
// A camera as the renderer needs it: projection with derivatives, and the outline of a ball.
#pragma once

#include <span>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint::sim {

/// A point of a closed outline in the distorted image and its derivative by the outline's parameter, times
/// the step.
struct OutlinePoint {
  double x_px = 0.0, y_px = 0.0;
  double dx_px = 0.0, dy_px = 0.0;
};

/// Area and mean of what an outline encloses.
struct OutlineMoments {
  double area_px2 = 0.0;  ///< positive
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  double orientation = 1.0;  ///< +1: the outline runs from +x to +y
};
OutlineMoments moments(std::span<const OutlinePoint> outline) noexcept;

class SimCamera {
 public:
  explicit SimCamera(const CameraCalibration& calibration);

  /// This camera, turned about its own y axis.
  SimCamera turned(double angle_rad) const;

  const CameraCalibration& calibration() const noexcept { return calibration_; }
  const Eigen::Vector3d& position_in_world() const noexcept { return position_in_world_; }
  const Eigen::Matrix3d& camera_from_world_rotation() const noexcept { return rotation_; }
  Eigen::Vector3d in_camera(const Eigen::Vector3d& point_in_world) const noexcept {
    return rotation_ * (point_in_world - position_in_world_);
  }
  /// Whether the lens can image that direction: in front, and before the distortion model folds over, with
  /// room for a ball around it.
  bool images(const Eigen::Vector3d& point_in_camera, double radius_m) const noexcept;
  /// Distorted pixel of a point that images(); `by_camera`, if given, receives its derivative.
  Eigen::Vector2d project(const Eigen::Vector3d& point_in_camera,
                          Eigen::Matrix<double, 2, 3>* by_camera = nullptr) const noexcept;
  /// The exact outline of a ball: the cone that touches it, through the lens.
  void outline(const Eigen::Vector3d& centre_in_camera, double radius_m,
               std::span<OutlinePoint> points) const noexcept;

 private:
  CameraCalibration calibration_;
  Eigen::Matrix3d rotation_;  // camera from world
  Eigen::Vector3d position_in_world_;
  double max_tangent_ = 0.0;  // largest radius in the z = 1 plane at which the lens model is monotonic
};

}  // namespace glint::sim
