// SPDX-License-Identifier: MIT
#include "host/calibrate/sighting_model.hpp"

#include <algorithm>

namespace glint {

Intrinsics intrinsics_of(const CameraCalibration& c) {
  Intrinsics all{c.fx_px, c.fy_px, c.cx_px, c.cy_px};
  std::copy(c.k1_k2_p1_p2_k3.begin(), c.k1_k2_p1_p2_k3.end(), all.begin() + 4);
  return all;
}

void set_intrinsics(CameraCalibration& c, const Intrinsics& all) {
  c.fx_px = all[0], c.fy_px = all[1], c.cx_px = all[2], c.cy_px = all[3];
  std::copy(all.begin() + 4, all.end(), c.k1_k2_p1_p2_k3.begin());
}

bool predict_sighting(const double* intrinsics, const Eigen::Vector3d& point, double marker_radius_m,
                      PredictedSighting& predicted) noexcept {
  constexpr double kNearest_m = 1e-3;  // nearer than this nothing is in focus, and divisions go wild
  const double z = point.z(), r2 = marker_radius_m * marker_radius_m;
  if (!(z > kNearest_m) || !(z * z > 2.0 * r2)) return false;
  // The outline's centre lies further out than the image of the sphere's centre (geometry/sphere_bias.hpp).
  const double outwards = z * z / (z * z - r2);
  const double outwards_by_z = -2.0 * z * r2 / ((z * z - r2) * (z * z - r2));
  const double x = outwards * point.x() / z, y = outwards * point.y() / z;
  Eigen::Matrix<double, 2, 3> plane_by_point;
  plane_by_point << outwards / z, 0.0, outwards_by_z * point.x() / z - x / z,  //
      0.0, outwards / z, outwards_by_z * point.y() / z - y / z;

  const double fx = intrinsics[0], fy = intrinsics[1];
  const double k1 = intrinsics[4], k2 = intrinsics[5], p1 = intrinsics[6], p2 = intrinsics[7],
               k3 = intrinsics[8];
  const double s = x * x + y * y;
  const double radial = 1.0 + s * (k1 + s * (k2 + s * k3));
  const double radial_by_s = k1 + s * (2.0 * k2 + 3.0 * s * k3);
  const double xd = x * radial + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x);
  const double yd = y * radial + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y;
  Eigen::Matrix2d bent_by_plane;
  bent_by_plane(0, 0) = radial + 2.0 * x * x * radial_by_s + 2.0 * p1 * y + 6.0 * p2 * x;
  bent_by_plane(0, 1) = 2.0 * x * y * radial_by_s + 2.0 * p1 * x + 2.0 * p2 * y;
  bent_by_plane(1, 0) = bent_by_plane(0, 1);
  bent_by_plane(1, 1) = radial + 2.0 * y * y * radial_by_s + 6.0 * p1 * y + 2.0 * p2 * x;

  predicted.pixel = {fx * xd + intrinsics[2], fy * yd + intrinsics[3]};
  predicted.by_point_in_camera = Eigen::Vector2d(fx, fy).asDiagonal() * bent_by_plane * plane_by_point;
  predicted.by_intrinsics << xd, 0.0, 1.0, 0.0, fx * x * s, fx * x * s * s, fx * 2.0 * x * y,
      fx * (s + 2.0 * x * x),
      fx * x * s * s * s,  //
      0.0, yd, 0.0, 1.0, fy * y * s, fy * y * s * s, fy * (s + 2.0 * y * y), fy * 2.0 * x * y,
      fy * y * s * s * s;
  return true;
}

}  // namespace glint
