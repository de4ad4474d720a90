// SPDX-License-Identifier: MIT
// From the covariance of camera_from_world to that of the camera's place.
#include "host/calibrate/camera_sd.hpp"

#include <algorithm>
#include <cmath>

#include "host/base/check.hpp"

namespace glint {

std::vector<CameraSd> camera_sd(const Calibration& calibration, const CalibrationUncertainty& uncertainty) {
  std::vector<CameraSd> all;
  if (uncertainty.covariance.size() == 0) return all;
  const Eigen::Index block = uncertainty.intrinsics ? 15 : 6;
  GLINT_CHECK(uncertainty.covariance.rows() == block * static_cast<Eigen::Index>(calibration.cameras.size()));
  for (std::size_t i = 0; i < calibration.cameras.size(); ++i) {
    const Eigen::Index at = static_cast<Eigen::Index>(i) * block;
    const Pose camera_from_world = calibration.cameras[i].world_from_camera.inverse();
    const Eigen::Matrix3d turn = camera_from_world.rotation.conjugate().toRotationMatrix();
    const Eigen::Vector3d& t = camera_from_world.translation;
    // The place is -R' t; with exp(w) R and t + d it moves by -R' (t x w + d).
    Eigen::Matrix3d cross;
    cross << 0.0, -t.z(), t.y(), t.z(), 0.0, -t.x(), -t.y(), t.x(), 0.0;
    Eigen::Matrix<double, 3, 6> by_pose;
    by_pose << -turn * cross, -turn;
    const Eigen::Matrix3d place = by_pose * uncertainty.covariance.block<6, 6>(at, at) * by_pose.transpose();
    CameraSd sd;
    sd.position_m = place.diagonal().cwiseMax(0.0).cwiseSqrt();
    sd.orientation_rad = std::sqrt(std::max(0.0, uncertainty.covariance.block<3, 3>(at, at).trace()));
    for (Eigen::Index k = 6; k < block; ++k) {
      sd.intrinsics[static_cast<std::size_t>(k - 6)] =
          std::sqrt(std::max(0.0, uncertainty.covariance(at + k, at + k)));
    }
    all.push_back(sd);
  }
  return all;
}

}  // namespace glint
