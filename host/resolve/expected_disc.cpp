// SPDX-License-Identifier: MIT
// Outlines of balls, carried through the lens by four points.
#include "host/resolve/expected_disc.hpp"

#include <array>
#include <cmath>

#include <Eigen/LU>

#include "gpu/lens_model.hpp"

namespace glint {
namespace {

gpu::Lens lens_of(const Camera& camera) noexcept {
  const CameraCalibration& c = camera.calibration();
  return {c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.k1_k2_p1_p2_k3};
}

/// Four points with mean and covariance of an evenly filled ellipse { v' shape^-1 v <= 1 } (shape / 4): what
/// is averaged over them is averaged over the ellipse, to second order.
std::array<Eigen::Vector2d, 4> four_points(const Eigen::Vector2d& centre,
                                           const Eigen::Matrix2d& shape) noexcept {
  // Columns of a Cholesky factor, over the root of two.
  const double xx = std::sqrt(0.5 * shape(0, 0));
  const double xy = 0.5 * shape(0, 1) / xx;
  const Eigen::Vector2d a(xx, xy), b(0.0, std::sqrt(std::max(0.0, 0.5 * shape(1, 1) - xy * xy)));
  return {centre + a, centre - a, centre + b, centre - b};
}

}  // namespace

std::optional<ExpectedDisc> expected_disc(const Camera& camera, const Eigen::Vector3d& position_in_world,
                                          const Eigen::Vector3d& velocity_in_world, double marker_radius_m,
                                          double exposure_s) noexcept {
  const Eigen::Vector3d c = camera.in_camera(position_in_world);
  if (!(c.z() > marker_radius_m) || !(marker_radius_m > 0.0)) return std::nullopt;
  // Rays x that touch the ball: (x.c)^2 = k |x|^2 with k = |c|^2 - r^2 (see sphere_bias.hpp). With x = (u, 1)
  // that is u' A u + 2 b' u + d = 0, an ellipse since the ball lies in front.
  const double k = c.squaredNorm() - marker_radius_m * marker_radius_m;
  const Eigen::Vector2d side = c.head<2>();
  const Eigen::Matrix2d a = side * side.transpose() - k * Eigen::Matrix2d::Identity();
  const Eigen::Matrix2d inverse = a.inverse();
  const Eigen::Vector2d b = side * c.z();
  const Eigen::Vector2d centre = -inverse * b;
  const Eigen::Matrix2d shape = -(c.z() * c.z() - k + b.dot(centre)) * inverse;

  // Through the lens. In the image the ellipse is filled evenly, so that where the lens magnifies counts
  // more.
  const gpu::Lens lens = lens_of(camera);
  const std::array<Eigen::Vector2d, 4> points = four_points(centre, shape);
  std::array<Eigen::Vector2d, 4> pixels;
  std::array<double, 4> weights;
  double sum = 0.0;
  ExpectedDisc disc;
  for (std::size_t i = 0; i < 4; ++i) {
    const gpu::Forward f = gpu::forward(lens, points[i].x(), points[i].y());
    if (!f.positive_definite()) return std::nullopt;
    pixels[i] = {lens.fx_px * f.x + lens.cx_px, lens.fy_px * f.y + lens.cy_px};
    weights[i] = f.determinant();
    sum += weights[i];
    disc.centre_px += weights[i] * pixels[i];
  }
  disc.centre_px /= sum;
  disc.shape_px2.setZero();
  for (std::size_t i = 0; i < 4; ++i) {
    const Eigen::Vector2d v = pixels[i] - disc.centre_px;
    disc.shape_px2 += 4.0 * weights[i] / sum * v * v.transpose();
  }

  const gpu::Forward f = gpu::forward(lens, c.x() / c.z(), c.y() / c.z());
  const Eigen::Vector3d v = camera.camera_from_world_rotation() * velocity_in_world;
  const Eigen::Vector2d on_plane = exposure_s / c.z() * (v.head<2>() - side * (v.z() / c.z()));
  disc.motion_px = {lens.fx_px * (f.xx * on_plane.x() + f.xy * on_plane.y()),
                    lens.fy_px * (f.xy * on_plane.x() + f.yy * on_plane.y())};
  disc.distance_m = c.norm();
  return disc;
}

std::optional<OutlineCentre> outline_centre(const Camera& camera, const Eigen::Vector2d& centroid_px,
                                            const Eigen::Matrix2d& shape_px2,
                                            const Eigen::Matrix2d& covariance_px2) noexcept {
  const gpu::Lens lens = lens_of(camera);
  OutlineCentre centre;
  double sum = 0.0;
  for (const Eigen::Vector2d& pixel : four_points(centroid_px, shape_px2)) {
    const gpu::Undistorted u = gpu::undistort(lens, pixel.x(), pixel.y());
    if (!u.converged) return std::nullopt;
    const double weight = 1.0 / gpu::forward(lens, u.x, u.y).determinant();
    centre.normalized += weight * Eigen::Vector2d(u.x, u.y);
    sum += weight;
  }
  centre.normalized /= sum;
  const gpu::Forward f = gpu::forward(lens, centre.normalized.x(), centre.normalized.y());
  // Raw pixels by undistorted ones.
  Eigen::Matrix2d by_undistorted;
  by_undistorted << f.xx, f.xy * lens.fx_px / lens.fy_px, f.xy * lens.fy_px / lens.fx_px, f.yy;
  const Eigen::Matrix2d inverse = by_undistorted.inverse();
  centre.covariance_px2 = inverse * covariance_px2 * inverse.transpose();
  return centre;
}

}  // namespace glint
