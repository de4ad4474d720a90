// SPDX-License-Identifier: MIT
// Projection and its inverse; the lens model itself is gpu/lens.hpp, shared with the detector.
#include "host/geometry/camera.hpp"

#include "gpu/lens.hpp"

namespace glint {
namespace {

// Points nearer to the camera plane than this are treated as behind it: their image is at infinity.
constexpr double kMinDepthM = 1e-9;

gpu::Lens lens_of(const CameraCalibration& c) noexcept {
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3};
}

}  // namespace

Camera::Camera(const CameraCalibration& calibration)
    : calibration_(calibration),
      camera_from_world_rotation_(
          calibration.world_from_camera.rotation.normalized().toRotationMatrix().transpose()),
      camera_from_world_translation_(
          -(camera_from_world_rotation_ * calibration.world_from_camera.translation)),
      position_in_world_(calibration.world_from_camera.translation) {}

Eigen::Vector3d Camera::in_camera(const Eigen::Vector3d& point_in_world) const noexcept {
  return camera_from_world_rotation_ * point_in_world + camera_from_world_translation_;
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& point_in_world) const noexcept {
  const Eigen::Vector3d p = in_camera(point_in_world);
  if (!(p.z() > kMinDepthM)) return std::nullopt;
  Eigen::Vector2d pixel;
  gpu::distort(lens_of(calibration_), p.x() / p.z(), p.y() / p.z(), pixel.x(), pixel.y());
  return pixel;
}

std::optional<Eigen::Vector2d> Camera::project_pinhole(const Eigen::Vector3d& point_in_world) const noexcept {
  const Eigen::Vector3d p = in_camera(point_in_world);
  if (!(p.z() > kMinDepthM)) return std::nullopt;
  return Eigen::Vector2d(calibration_.fx_px * p.x() / p.z() + calibration_.cx_px,
                         calibration_.fy_px * p.y() / p.z() + calibration_.cy_px);
}

std::optional<Eigen::Vector2d> Camera::undistort(const Eigen::Vector2d& pixel) const noexcept {
  const gpu::Undistorted u = gpu::undistort(lens_of(calibration_), pixel.x(), pixel.y());
  if (!u.converged) return std::nullopt;
  return Eigen::Vector2d(u.x, u.y);
}

Eigen::Vector3d Camera::direction_in_world(const Eigen::Vector2d& normalized) const noexcept {
  return (camera_from_world_rotation_.transpose() * normalized.homogeneous()).normalized();
}

bool Camera::inside(const Eigen::Vector2d& pixel, double margin_px) const noexcept {
  // Pixel centres are integers, so that the image reaches half a pixel further.
  return pixel.x() >= -0.5 + margin_px && pixel.y() >= -0.5 + margin_px &&
         pixel.x() <= static_cast<double>(calibration_.width_px) - 0.5 - margin_px &&
         pixel.y() <= static_cast<double>(calibration_.height_px) - 0.5 - margin_px;
}

}  // namespace glint
