// SPDX-License-Identifier: MIT
// Calibrated cameras: projection, rays, undistortion.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/geometry/pose.hpp"

namespace glint {

/// One camera as a calibration file describes it. Camera frame: x right, y down, z forward. Focal lengths may
/// be negative (a mirrored axis, as some tools write).
struct CameraCalibration {
  std::string name;
  std::uint32_t width_px = 0, height_px = 0;
  double fx_px = 1.0, fy_px = 1.0, cx_px = 0.0, cy_px = 0.0;
  std::array<double, 5> k1_k2_p1_p2_k3{};  ///< OpenCV's order
  std::array<double, 9>
      intrinsics_sd{};  ///< standard deviations of fx fy cx cy k1 k2 p1 p2 k3; all 0: unknown
  Pose world_from_camera;
  double rms_px = 0.0;  ///< reprojection error of the calibration; 0: unknown
};

struct Calibration {
  std::vector<CameraCalibration> cameras;
  std::string made_at, made_from;
};

/// A camera ready for projecting: constants of CameraCalibration turned round once.
class Camera {
 public:
  explicit Camera(const CameraCalibration& calibration);

  const CameraCalibration& calibration() const noexcept { return calibration_; }
  const Eigen::Vector3d& position_in_world() const noexcept { return position_in_world_; }
  /// Rows are the camera's axes in the world.
  const Eigen::Matrix3d& camera_from_world_rotation() const noexcept { return camera_from_world_rotation_; }

  Eigen::Vector3d in_camera(const Eigen::Vector3d& point_in_world) const noexcept;
  /// Distorted pixel of a point; nothing if it lies behind the camera. It may lie outside the image.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point_in_world) const noexcept;
  /// Undistorted pixel (ideal pinhole with the same focal lengths and centre).
  std::optional<Eigen::Vector2d> project_pinhole(const Eigen::Vector3d& point_in_world) const noexcept;
  /// z = 1 plane from a distorted pixel; nothing where the lens model folds over.
  std::optional<Eigen::Vector2d> undistort(const Eigen::Vector2d& pixel) const noexcept;
  /// Unit direction in the world of a z = 1 plane point.
  Eigen::Vector3d direction_in_world(const Eigen::Vector2d& normalized) const noexcept;
  bool inside(const Eigen::Vector2d& pixel, double margin_px = 0.0) const noexcept;

 private:
  CameraCalibration calibration_;
  Eigen::Matrix3d camera_from_world_rotation_;
  Eigen::Vector3d camera_from_world_translation_;
  Eigen::Vector3d position_in_world_;
};

}  // namespace glint
