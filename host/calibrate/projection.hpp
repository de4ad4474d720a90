// SPDX-License-Identifier: MIT
// The camera model in a form that Ceres can differentiate. The same model as gpu/lens.hpp.
#pragma once

#include <array>

#include <ceres/rotation.h>
#include <Eigen/Core>
#include <Eigen/Geometry>

#include "host/geometry/camera.hpp"

namespace glint {

/// fx fy cx cy k1 k2 p1 p2 k3, as solvers move them.
using IntrinsicsBlock = std::array<double, 9>;
/// Rotation vector, then translation, of camera_from_something.
using PoseBlock = std::array<double, 6>;

inline IntrinsicsBlock intrinsics_block(const CameraCalibration& c) {
  const auto& k = c.k1_k2_p1_p2_k3;
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, k[0], k[1], k[2], k[3], k[4]};
}

inline void set_intrinsics(CameraCalibration& c, const IntrinsicsBlock& block) {
  c.fx_px = block[0];
  c.fy_px = block[1];
  c.cx_px = block[2];
  c.cy_px = block[3];
  for (std::size_t i = 0; i < 5; ++i) c.k1_k2_p1_p2_k3[i] = block[4 + i];
}

inline PoseBlock pose_block(const Pose& pose) {
  const Eigen::AngleAxisd turn(pose.rotation);
  const Eigen::Vector3d r = turn.angle() * turn.axis(), &t = pose.translation;
  return {r.x(), r.y(), r.z(), t.x(), t.y(), t.z()};
}

inline Pose pose_of(const PoseBlock& block) {
  const Eigen::Vector3d r(block[0], block[1], block[2]);
  const double angle = r.norm();
  const Eigen::Vector3d axis = angle > 0.0 ? Eigen::Vector3d(r / angle) : Eigen::Vector3d::UnitX();
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, axis)), {block[3], block[4], block[5]}};
}

/// Pixel of a point in camera coordinates; false if it is not in front of the camera.
template <typename T>
bool project(const T* intrinsics, const T* in_camera, T* pixel) {
  if (!(in_camera[2] > 1e-9)) return false;
  const T x = in_camera[0] / in_camera[2], y = in_camera[1] / in_camera[2];
  const T q = x * x + y * y;
  const T radial = 1.0 + q * (intrinsics[4] + q * (intrinsics[5] + q * intrinsics[8]));
  const T &p1 = intrinsics[6], &p2 = intrinsics[7];
  pixel[0] = intrinsics[0] * (x * radial + 2.0 * p1 * x * y + p2 * (q + 2.0 * x * x)) + intrinsics[2];
  pixel[1] = intrinsics[1] * (y * radial + p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y) + intrinsics[3];
  return true;
}

/// Of a point in the frame that `pose` leads from.
template <typename T>
bool project(const T* intrinsics, const T* pose, const Eigen::Vector3d& point, T* pixel) {
  const T in_frame[3] = {T(point.x()), T(point.y()), T(point.z())};
  T in_camera[3];
  ceres::AngleAxisRotatePoint(pose, in_frame, in_camera);
  for (int i = 0; i < 3; ++i) in_camera[i] += pose[3 + i];
  return project(intrinsics, in_camera, pixel);
}

}  // namespace glint
