// SPDX-License-Identifier: MIT
// The point that two or more cameras see, with its covariance.
#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"

namespace glint {

/// What one camera measured.
struct Observation {
  const Camera* camera = nullptr;                                ///< borrowed for the call
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();          ///< z = 1 plane, undistorted
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();  ///< in undistorted pixels
};

/// What is known of the position beforehand.
struct PositionPrior {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
};

struct TriangulateOptions {
  double marker_radius_m = 0.0;  ///< > 0: the blobs are outlines of spheres, whose projection bias is removed
  double min_angle_rad = 0.02;   ///< at least two rays must meet at this angle (and as far from 180 degrees)
};

struct Triangulated {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 =
      Eigen::Matrix3d::Zero();  ///< from the observations' covariances (and the prior)
  double rms_px = 0.0;  ///< root mean square over the views of the residual's length, undistorted pixels
  double chi2 = 0.0;    ///< sum of squared residuals over their covariances; 2 * views - 3 degrees of freedom
                        ///< (2 * views with a prior, whose deviation is included)
  unsigned views = 0;
  /// Of the views alone, at the position: inverse covariance, and the gradient of their log-likelihood, which
  /// is 0 without a prior.
  Eigen::Matrix3d information_per_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_per_m = Eigen::Vector3d::Zero();
};

/// Linear least squares over all rays, then Gauss-Newton on the reprojection error in undistorted pixels,
/// weighted by the covariances (Hartley and Zisserman, Multiple View Geometry, 12.2 and 12.3). Nothing if
/// there are fewer than two views, if the point lies behind a camera, if no two rays meet at a usable angle,
/// or if it does not converge. Does not allocate.
std::optional<Triangulated> triangulate(std::span<const Observation> views, const TriangulateOptions& options,
                                        const PositionPrior* prior = nullptr) noexcept;

/// The same from a given start, and with a prior for any number of views at any angle: one view is enough.
std::optional<Triangulated> refine_point(std::span<const Observation> views,
                                         const TriangulateOptions& options,
                                         const Eigen::Vector3d& start_in_world,
                                         const PositionPrior* prior = nullptr) noexcept;

/// Whether two of the rays meet at a usable angle, so that no prior is needed.
bool rays_fix_position(std::span<const Observation> views, double min_angle_rad) noexcept;

/// Measured minus predicted, undistorted pixels; the point must lie in front of the camera.
Eigen::Vector2d reprojection_residual_px(const Observation& view, const Eigen::Vector3d& point_in_world,
                                         double marker_radius_m) noexcept;

/// Undistorted pixel of a point and its derivative by the point; false if it lies behind the camera.
bool project_pinhole(const Camera& camera, const Eigen::Vector3d& point_in_world, Eigen::Vector2d& pixel,
                     Eigen::Matrix<double, 2, 3>& pixel_by_point) noexcept;

/// The same of a sphere's outline: its centre is not where the sphere's centre is
/// (host/geometry/sphere_bias.hpp). The derivative leaves out the bias's own, (r/z)^2 of it. Radius 0: a
/// point.
bool project_outline(const Camera& camera, const Eigen::Vector3d& centre_in_world, double radius_m,
                     Eigen::Vector2d& pixel, Eigen::Matrix<double, 2, 3>& pixel_by_point) noexcept;

}  // namespace glint
