// SPDX-License-Identifier: MIT
// Linear equations for 1/fx^2 and 1/fy^2.
#include "host/calibrate/zhang_start.hpp"

#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/SVD>

namespace glint {

CameraCalibration zhang_start(std::span<const Eigen::Matrix3d> image_from_plane, std::uint32_t width_px,
                              std::uint32_t height_px) {
  CameraCalibration camera;
  camera.width_px = width_px;
  camera.height_px = height_px;
  camera.cx_px = 0.5 * (width_px - 1.0);
  camera.cy_px = 0.5 * (height_px - 1.0);
  camera.fx_px = camera.fy_px = width_px;

  const double scale_px = width_px;  // so that all unknowns are about 1
  Eigen::Matrix3d to_centre;
  to_centre << 1.0 / scale_px, 0.0, -camera.cx_px / scale_px, 0.0, 1.0 / scale_px, -camera.cy_px / scale_px,
      0.0, 0.0, 1.0;
  Eigen::MatrixX2d left(2 * image_from_plane.size(), 2);
  Eigen::VectorXd right(2 * image_from_plane.size());
  for (std::size_t i = 0; i < image_from_plane.size(); ++i) {
    const Eigen::Matrix3d h = to_centre * image_from_plane[i];
    const double size = h.col(0).norm() * h.col(1).norm();
    const Eigen::Vector3d a = h.col(0) / std::sqrt(size), b = h.col(1) / std::sqrt(size);
    const auto row = static_cast<Eigen::Index>(2 * i);
    // The plane's axes are at right angles and equally long, seen through diag(1/fx^2, 1/fy^2, 1).
    left.row(row) << a.x() * b.x(), a.y() * b.y();
    right[row] = -a.z() * b.z();
    left.row(row + 1) << a.x() * a.x() - b.x() * b.x(), a.y() * a.y() - b.y() * b.y();
    right[row + 1] = b.z() * b.z() - a.z() * a.z();
  }
  if (image_from_plane.empty()) return camera;
  const Eigen::Vector2d inverse_squares = left.bdcSvd(Eigen::ComputeThinU | Eigen::ComputeThinV).solve(right);
  const Eigen::Array2d focal_px = scale_px / inverse_squares.array().max(1e-12).sqrt();
  // Lenses of 20 to 150 degrees; anything else is a sign of views that do not tell.
  const bool plausible = (inverse_squares.array() > 0.0).all() && (focal_px > 0.13 * scale_px).all() &&
                         (focal_px < 3.0 * scale_px).all();
  if (plausible) {
    camera.fx_px = focal_px[0];
    camera.fy_px = focal_px[1];
  }
  return camera;
}

Eigen::Vector3d plane_normal(const CameraCalibration& camera, const Eigen::Matrix3d& image_from_plane) {
  Eigen::Matrix3d normalized;
  normalized << 1.0 / camera.fx_px, 0.0, -camera.cx_px / camera.fx_px, 0.0, 1.0 / camera.fy_px,
      -camera.cy_px / camera.fy_px, 0.0, 0.0, 1.0;
  const Eigen::Matrix3d h = normalized * image_from_plane;
  const Eigen::Vector3d normal = h.col(0).cross(h.col(1)).normalized();
  return normal.dot(h.col(2)) < 0.0 ? normal : Eigen::Vector3d(-normal);
}

}  // namespace glint
