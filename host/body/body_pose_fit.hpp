// SPDX-License-Identifier: MIT
// A body's pose from what cameras see of its markers.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include <Eigen/Core>

#include "host/body/body_model.hpp"
#include "host/geometry/camera.hpp"

namespace glint {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;  ///< of a pose: rotation vector in the world, then translation

/// What one camera measured of one marker.
struct BodyView {
  const Camera* camera = nullptr;                                ///< borrowed for the call
  Eigen::Vector2d normalized = Eigen::Vector2d::Zero();          ///< z = 1 plane, undistorted
  Eigen::Matrix2d covariance_px2 = Eigen::Matrix2d::Identity();  ///< in undistorted pixels
  std::uint32_t marker = 0;
};

/// What is known of the pose beforehand: the true one is moved(world_from_body, error).
struct PosePrior {
  Pose world_from_body;
  Matrix6 covariance = Matrix6::Identity();
};

struct BodyFitOptions {
  double marker_radius_m = 0.0;  ///< > 0: the blobs are outlines of spheres, whose projection bias is removed
  double marker_sd_m = kDefaultMarkerSd_m;  ///< of each marker's place in the body, per axis
  double outlier_chi2 = 18.4;               ///< two degrees of freedom: a true view is refused once in 10,000
};

struct BodyFit {
  Pose world_from_body;
  Matrix6 covariance = Matrix6::Zero();  ///< prior included
  double chi2 = 0.0;                     ///< of the views that were used, without the prior's part
  double prior_chi2 = 0.0;               ///< by how much it left the prior; 6 degrees of freedom
  double rms_px = 0.0;                   ///< of the used views' residuals
  unsigned views = 0, outliers = 0;
};

/// Levenberg-Marquardt on the reprojection error in undistorted pixels. Each marker's place in the body has
/// an error of its own, common to all its views, which is eliminated, so that many cameras on one marker do
/// not pretend to know more than the model does. If all views agree they have equal rights; else the fit is
/// begun anew with Huber's loss, and views beyond outlier_chi2 are left out of the final one. `outlier` (as
/// long as `views`) tells which. Few views are enough with a prior; without one nothing comes back unless the
/// views determine the pose. Nothing either if it does not converge or a marker comes behind its camera. Does
/// not allocate.
std::optional<BodyFit> fit_body_pose(std::span<const Eigen::Vector3d> markers_in_body,
                                     std::span<const BodyView> views, const Pose& start,
                                     const PosePrior* prior, const BodyFitOptions& options,
                                     std::span<std::uint8_t> outlier) noexcept;

/// Covariance of a point of the body in the world: the pose's share and the point's own.
Eigen::Matrix3d point_covariance(const Pose& world_from_body, const Matrix6& covariance,
                                 const Eigen::Vector3d& point_in_body, double point_sd_m) noexcept;

/// The pose moved by a rotation vector in the world and a translation, both at once, as a screw moves. So a
/// turn about any line is a straight step, and the uncertainty of a body of which two markers are seen is a
/// Gaussian, though it may be anywhere on a circle.
Pose moved(const Pose& pose, const Vector6& step) noexcept;

/// The step from `origin` to `pose`: moved(origin, pose_difference(pose, origin)) is `pose`.
Vector6 pose_difference(const Pose& pose, const Pose& origin) noexcept;

/// Derivative of pose_difference(moved(pose, step), origin) by a small step (Barfoot, State Estimation for
/// Robotics, 2017, 7.1.5, to third order).
Matrix6 difference_by_step(const Pose& pose, const Pose& origin) noexcept;

/// -2 log of the Gaussian density of a difference, up to the constant 6 log(2 pi); infinite if `covariance`
/// is none.
double gaussian_cost(const Vector6& difference, const Matrix6& covariance) noexcept;

}  // namespace glint
