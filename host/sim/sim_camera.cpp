// SPDX-License-Identifier: MIT
// Projection through the lens with derivatives; outline of a ball.
#include "host/sim/sim_camera.hpp"

#include <cmath>
#include <numbers>

namespace glint::sim {
namespace {

/// Largest radius up to which d(distorted radius)/d(radius) stays above a tenth: a real lens never folds its
/// image back, the polynomial does.
double monotonic_radius(const std::array<double, 5>& k) {
  constexpr double kStep = 0.005, kLargest = 4.0, kLeastSlope = 0.1;
  double r = 0.0;
  for (; r < kLargest; r += kStep) {
    const double q = r * r;
    if (1.0 + q * (3.0 * k[0] + q * (5.0 * k[1] + q * 7.0 * k[4])) < kLeastSlope) break;
  }
  return r;
}

}  // namespace

OutlineMoments moments(std::span<const OutlinePoint> outline) noexcept {
  // Green's theorem; the trapezoidal rule over a smooth closed curve converges faster than any power. Taken
  // about the first point, or the products would lose digits.
  OutlineMoments result;
  if (outline.empty()) return result;
  const double x0 = outline[0].x_px, y0 = outline[0].y_px;
  double area = 0.0, sum_x = 0.0, sum_y = 0.0;
  for (const OutlinePoint& p : outline) {
    const double x = p.x_px - x0, y = p.y_px - y0;
    area += x * p.dy_px;
    sum_x += 0.5 * x * x * p.dy_px;
    sum_y -= 0.5 * y * y * p.dx_px;
  }
  result.orientation = area < 0.0 ? -1.0 : 1.0;
  result.area_px2 = std::abs(area);
  if (area != 0.0) result.mean_px = Eigen::Vector2d(x0 + sum_x / area, y0 + sum_y / area);
  return result;
}

SimCamera::SimCamera(const CameraCalibration& calibration)
    : calibration_(calibration),
      rotation_(calibration.world_from_camera.rotation.conjugate().toRotationMatrix()),
      position_in_world_(calibration.world_from_camera.translation),
      max_tangent_(monotonic_radius(calibration.k1_k2_p1_p2_k3)) {}

SimCamera SimCamera::turned(double angle_rad) const {
  CameraCalibration other = calibration_;
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()));
  other.world_from_camera.rotation = (calibration_.world_from_camera.rotation * turn).normalized();
  return SimCamera(other);
}

bool SimCamera::images(const Eigen::Vector3d& point_in_camera, double radius_m) const noexcept {
  const double z = point_in_camera.z() - 2.0 * radius_m;  // a ball must be clear of the lens
  if (z <= 1e-3) return false;
  return point_in_camera.head<2>().norm() + radius_m < max_tangent_ * z;
}

Eigen::Vector2d SimCamera::project(const Eigen::Vector3d& point_in_camera,
                                   Eigen::Matrix<double, 2, 3>* by_camera) const noexcept {
  const auto& [k1, k2, p1, p2, k3] = calibration_.k1_k2_p1_p2_k3;
  const double inverse_z = 1.0 / point_in_camera.z();
  const double x = point_in_camera.x() * inverse_z, y = point_in_camera.y() * inverse_z;
  const double q = x * x + y * y;
  const double radial = 1.0 + q * (k1 + q * (k2 + q * k3));
  const Eigen::Vector2d pixel(
      calibration_.fx_px * (x * radial + 2.0 * p1 * x * y + p2 * (q + 2.0 * x * x)) + calibration_.cx_px,
      calibration_.fy_px * (y * radial + p1 * (q + 2.0 * y * y) + 2.0 * p2 * x * y) + calibration_.cy_px);
  if (by_camera != nullptr) {
    const double slope = 2.0 * (k1 + q * (2.0 * k2 + q * 3.0 * k3));  // d(radial)/dx = slope * x
    const double cross = x * y * slope + 2.0 * p1 * x + 2.0 * p2 * y;
    Eigen::Matrix2d by_plane;
    by_plane << radial + x * x * slope + 2.0 * p1 * y + 6.0 * p2 * x, cross, cross,
        radial + y * y * slope + 6.0 * p1 * y + 2.0 * p2 * x;
    by_plane.row(0) *= calibration_.fx_px;
    by_plane.row(1) *= calibration_.fy_px;
    Eigen::Matrix<double, 2, 3> plane_by_camera;
    plane_by_camera << inverse_z, 0.0, -x * inverse_z, 0.0, inverse_z, -y * inverse_z;
    *by_camera = by_plane * plane_by_camera;
  }
  return pixel;
}

void SimCamera::outline(const Eigen::Vector3d& centre_in_camera, double radius_m,
                        std::span<OutlinePoint> points) const noexcept {
  const double distance = centre_in_camera.norm();
  const double sine = radius_m / distance;
  const Eigen::Vector3d axis = centre_in_camera / distance;
  const Eigen::Vector3d side = axis.unitOrthogonal();
  const Eigen::Vector3d right = sine * side, down = sine * axis.cross(side);
  const Eigen::Vector3d along = std::sqrt(1.0 - sine * sine) * axis;
  const double step = 2.0 * std::numbers::pi / static_cast<double>(points.size());
  // Turns by angle addition: two multiplications a point instead of sine and cosine.
  const double cos_step = std::cos(step), sin_step = std::sin(step);
  double c = 1.0, s = 0.0;
  for (OutlinePoint& point : points) {
    Eigen::Matrix<double, 2, 3> by_camera;
    const Eigen::Vector2d pixel = project(along + c * right + s * down, &by_camera);
    const Eigen::Vector2d tangent = by_camera * (c * down - s * right) * step;
    point = {pixel.x(), pixel.y(), tangent.x(), tangent.y()};
    const double next = c * cos_step - s * sin_step;
    s = s * cos_step + c * sin_step;
    c = next;
  }
}

}  // namespace glint::sim
