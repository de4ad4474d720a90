// SPDX-License-Identifier: MIT
// Linear least squares, then Gauss-Newton on the reprojection error.
#include "host/geometry/triangulate.hpp"

#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include "host/geometry/sphere_bias.hpp"

namespace glint {
namespace {

constexpr int kMaxSteps = 12;  // Gauss-Newton converges in two to four on anything well conditioned

// Each view gives two equations linear in the point: (u r3 - r1) (X - c) = 0 and the same with v, where
// r1..r3 are the camera's axes and c its position. Coordinates are relative to the first camera, for
// conditioning.
bool solve_linear(std::span<const Observation> views, Eigen::Vector3d& point_in_world) noexcept {
  const Eigen::Vector3d origin = views.front().camera->position_in_world();
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Observation& view : views) {
    const Eigen::Matrix3d& r = view.camera->camera_from_world_rotation();
    const Eigen::Vector3d c = view.camera->position_in_world() - origin;
    for (int k = 0; k < 2; ++k) {
      const Eigen::Vector3d row = (view.normalized[k] * r.row(2) - r.row(k)).transpose();
      a.noalias() += row * row.transpose();
      b.noalias() += row * row.dot(c);
    }
  }
  const Eigen::LDLT<Eigen::Matrix3d> factor(a);
  if (factor.info() != Eigen::Success) return false;
  point_in_world = origin + factor.solve(b);
  return point_in_world.allFinite();
}

}  // namespace

bool rays_fix_position(std::span<const Observation> views, double min_angle_rad) noexcept {
  const double min_sine2 = std::pow(std::sin(min_angle_rad), 2);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const Eigen::Vector3d a = views[i].camera->direction_in_world(views[i].normalized);
    for (std::size_t j = i + 1; j < views.size(); ++j)
      if (a.cross(views[j].camera->direction_in_world(views[j].normalized)).squaredNorm() >= min_sine2)
        return true;
  }
  return false;
}

bool project_pinhole(const Camera& camera, const Eigen::Vector3d& point_in_world, Eigen::Vector2d& pixel,
                     Eigen::Matrix<double, 2, 3>& pixel_by_point) noexcept {
  const Eigen::Vector3d p = camera.in_camera(point_in_world);
  if (!(p.z() > 1e-9)) return false;
  const CameraCalibration& c = camera.calibration();
  const Eigen::Matrix3d& r = camera.camera_from_world_rotation();
  const double x = p.x() / p.z(), y = p.y() / p.z();
  pixel = {c.fx_px * x + c.cx_px, c.fy_px * y + c.cy_px};
  pixel_by_point.row(0) = c.fx_px / p.z() * (r.row(0) - x * r.row(2));
  pixel_by_point.row(1) = c.fy_px / p.z() * (r.row(1) - y * r.row(2));
  return true;
}

bool project_outline(const Camera& camera, const Eigen::Vector3d& centre_in_world, double radius_m,
                     Eigen::Vector2d& pixel, Eigen::Matrix<double, 2, 3>& pixel_by_point) noexcept {
  if (!project_pinhole(camera, centre_in_world, pixel, pixel_by_point)) return false;
  if (radius_m > 0.0) {
    const Eigen::Vector2d middle(camera.calibration().cx_px, camera.calibration().cy_px);
    pixel = middle + sphere_bias_factor(radius_m, camera.in_camera(centre_in_world).z()) * (pixel - middle);
  }
  return true;
}

Eigen::Vector2d reprojection_residual_px(const Observation& view, const Eigen::Vector3d& point_in_world,
                                         double marker_radius_m) noexcept {
  const Eigen::Vector3d p = view.camera->in_camera(point_in_world);
  const Eigen::Vector2d predicted = p.hnormalized() * sphere_bias_factor(marker_radius_m, p.z());
  const CameraCalibration& c = view.camera->calibration();
  return {c.fx_px * (view.normalized.x() - predicted.x()), c.fy_px * (view.normalized.y() - predicted.y())};
}

std::optional<Triangulated> triangulate(std::span<const Observation> views, const TriangulateOptions& options,
                                        const PositionPrior* prior) noexcept {
  if (views.size() < 2 || !rays_fix_position(views, options.min_angle_rad)) return std::nullopt;
  Eigen::Vector3d start;
  if (!solve_linear(views, start)) return std::nullopt;
  return refine_point(views, options, start, prior);
}

std::optional<Triangulated> refine_point(std::span<const Observation> views,
                                         const TriangulateOptions& options,
                                         const Eigen::Vector3d& start_in_world,
                                         const PositionPrior* prior) noexcept {
  Triangulated result;
  result.views = static_cast<unsigned>(views.size());
  Eigen::Vector3d x = start_in_world;
  const Eigen::Matrix3d prior_information =
      prior != nullptr ? Eigen::Matrix3d(prior->covariance_m2.inverse()) : Eigen::Matrix3d::Zero();
  for (int step = 0;; ++step) {
    Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
    Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
    double chi2 = 0.0, squares = 0.0;
    for (const Observation& view : views) {
      Eigen::Vector2d pixel;
      Eigen::Matrix<double, 2, 3> jacobian;
      // The derivative leaves out that of the sphere's bias: (r/z)^2 of it, which only slows convergence.
      if (!project_pinhole(*view.camera, x, pixel, jacobian)) return std::nullopt;
      const Eigen::Vector2d r = reprojection_residual_px(view, x, options.marker_radius_m);
      const Eigen::Matrix2d weight = view.covariance_px2.inverse();
      const Eigen::Matrix<double, 3, 2> jw = jacobian.transpose() * weight;
      information.noalias() += jw * jacobian;
      gradient.noalias() += jw * r;
      chi2 += r.dot(weight * r);
      squares += r.squaredNorm();
    }
    result.information_per_m2 = information;
    result.gradient_per_m = gradient;
    if (prior != nullptr) {
      const Eigen::Vector3d d = prior->position_in_world - x, pull = prior_information * d;
      information += prior_information;
      gradient += pull;
      chi2 += d.dot(pull);
    }
    const Eigen::LDLT<Eigen::Matrix3d> factor(information);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
    const Eigen::Vector3d move = factor.solve(gradient);
    if (!move.allFinite()) return std::nullopt;
    // A step far below the standard deviation (its Mahalanobis length, squared) changes nothing that matters.
    const bool done = move.dot(gradient) < 1e-8;
    if (done || step == kMaxSteps) {
      if (!done && move.dot(gradient) > 1e-4) return std::nullopt;
      result.position_in_world = x;
      result.covariance_m2 = factor.solve(Eigen::Matrix3d::Identity());
      result.rms_px = std::sqrt(squares / static_cast<double>(views.size()));
      result.chi2 = chi2;
      return result;
    }
    x += move;
  }
}

}  // namespace glint
