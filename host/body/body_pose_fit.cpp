// SPDX-License-Identifier: MIT
// Levenberg-Marquardt with the markers' own errors eliminated.
#include "host/body/body_pose_fit.hpp"

#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "host/base/check.hpp"
#include "host/geometry/rotation.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {
namespace {

constexpr int kSteps = 15;                  // of one minimisation; from a prediction two to four are enough
constexpr int kHuberRounds = 4;             // weights, then steps, so often
constexpr int kRefusalRounds = 4;           // views left out or let in again, so often
constexpr double kHuberChi2 = 4.6;          // two degrees of freedom: a tenth of all views get less weight
constexpr double kLargestTurnSd_rad = 0.5;  // beyond, the views do not determine the pose
constexpr double kInfinity = std::numeric_limits<double>::infinity();

struct Problem {
  std::span<const Eigen::Vector3d> markers;
  std::span<const BodyView> views;
  const PosePrior* prior;
  const BodyFitOptions& options;
  Matrix6 prior_information;
};

struct Linear {
  Matrix6 information;
  Vector6 gradient;
  double cost = kInfinity;  ///< views and prior
  double prior_chi2 = 0.0;
};

struct MarkerSum {
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();  // of the marker's place in the world
  Eigen::Vector3d gradient = Eigen::Vector3d::Zero();
  double cost = 0.0;
  bool seen = false;
};

// The normal equations at `pose`; cost stays infinite if a marker lies behind a camera that saw it.
Linear linearize(const Problem& p, const Pose& pose, std::span<const double> weights) noexcept {
  Linear result;
  std::array<MarkerSum, kBodyMarkers> sums;
  for (std::size_t k = 0; k < p.views.size(); ++k) {
    if (weights[k] == 0.0) continue;
    const BodyView& view = p.views[k];
    const Eigen::Vector3d point = pose * p.markers[view.marker];
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 3> jacobian;
    if (!project_pinhole(*view.camera, point, pixel, jacobian)) return result;
    const Observation seen{view.camera, view.normalized, view.covariance_px2};
    const Eigen::Vector2d r = reprojection_residual_px(seen, point, p.options.marker_radius_m);
    const Eigen::Matrix2d information = weights[k] * view.covariance_px2.inverse();
    const Eigen::Matrix<double, 3, 2> jw = jacobian.transpose() * information;
    MarkerSum& sum = sums[view.marker];
    sum.information.noalias() += jw * jacobian;
    sum.gradient.noalias() += jw * r;
    sum.cost += r.dot(information * r);
    sum.seen = true;
  }
  result.information = p.prior_information;
  result.gradient.setZero();
  double cost = 0.0;
  if (p.prior != nullptr) {
    const Vector6 d = pose_difference(pose, p.prior->world_from_body);
    const Matrix6 by_step = difference_by_step(pose, p.prior->world_from_body);
    const Vector6 pull = p.prior_information * d;
    result.information = by_step.transpose() * p.prior_information * by_step;
    result.gradient = -by_step.transpose() * pull;
    result.prior_chi2 = d.dot(pull);
    cost = result.prior_chi2;
  }
  const double variance = p.options.marker_sd_m * p.options.marker_sd_m;
  for (std::size_t m = 0; m < p.markers.size(); ++m) {
    const MarkerSum& sum = sums[m];
    if (!sum.seen) continue;
    // Minimum over the marker's own error e of cost(e) + e^2 / variance.
    const Eigen::Matrix3d damping = (Eigen::Matrix3d::Identity() + variance * sum.information).inverse();
    const Eigen::Matrix3d information = sum.information * damping;
    const Eigen::Vector3d gradient = damping.transpose() * sum.gradient;
    cost += sum.cost - variance * sum.gradient.dot(damping * sum.gradient);
    Eigen::Matrix<double, 3, 6> by_pose;
    by_pose.leftCols<3>() = -cross_matrix(pose.rotation * p.markers[m]);
    by_pose.rightCols<3>().setIdentity();
    result.information.noalias() += by_pose.transpose() * information * by_pose;
    result.gradient.noalias() += by_pose.transpose() * gradient;
  }
  result.cost = cost;
  return result;
}

// True if it converged; `at` then belongs to `pose`.
bool minimise(const Problem& p, std::span<const double> weights, Pose& pose, Linear& at) noexcept {
  at = linearize(p, pose, weights);
  if (!std::isfinite(at.cost)) return false;
  double damping = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    Matrix6 damped = at.information;
    damped.diagonal() *= 1.0 + damping;
    const Eigen::LDLT<Matrix6> factor(damped);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return false;
    const Vector6 move = factor.solve(at.gradient);
    if (!move.allFinite()) return false;
    const double gain = move.dot(at.gradient);  // squared length in standard deviations
    if (gain < 1e-8) return true;
    const Pose next = moved(pose, move);
    const Linear there = linearize(p, next, weights);
    if (there.cost <= at.cost + 1e-9) {
      pose = next;
      at = there;
      damping = damping > 1e-4 ? 0.1 * damping : 0.0;
    } else {
      if (gain < 1e-4) return true;  // rounding is all that is left
      damping = damping == 0.0 ? 1e-3 : 10.0 * damping;
    }
  }
  return false;
}

// Of one view, its marker's own error included.
double chi2_of(const Problem& p, const BodyView& view, const Pose& pose) noexcept {
  const Eigen::Vector3d point = pose * p.markers[view.marker];
  Eigen::Vector2d pixel;
  Eigen::Matrix<double, 2, 3> jacobian;
  if (!project_pinhole(*view.camera, point, pixel, jacobian)) return kInfinity;
  const Observation seen{view.camera, view.normalized, view.covariance_px2};
  const Eigen::Vector2d r = reprojection_residual_px(seen, point, p.options.marker_radius_m);
  const Eigen::Matrix2d spread = view.covariance_px2 + p.options.marker_sd_m * p.options.marker_sd_m *
                                                           (jacobian * jacobian.transpose()).eval();
  return r.dot(spread.inverse() * r);
}

constexpr std::size_t kMaxViews = kBodyMarkers * 32;

std::size_t mark_outliers(const Problem& p, const Pose& pose, std::span<double> weights) noexcept {
  std::size_t changed = 0;
  for (std::size_t k = 0; k < p.views.size(); ++k) {
    const double weight = chi2_of(p, p.views[k], pose) > p.options.outlier_chi2 ? 0.0 : 1.0;
    changed += weight != weights[k] ? 1u : 0u;
    weights[k] = weight;
  }
  return changed;
}

}  // namespace

Pose moved(const Pose& pose, const Vector6& step) noexcept {
  return {(rotation_of(step.head<3>()) * pose.rotation).normalized(),
          pose.translation + left_jacobian(step.head<3>()) * step.tail<3>()};
}

Vector6 pose_difference(const Pose& pose, const Pose& origin) noexcept {
  Vector6 d;
  d.head<3>() = rotation_vector_of(pose.rotation * origin.rotation.conjugate());
  d.tail<3>() = left_jacobian(d.head<3>()).inverse() * (pose.translation - origin.translation);
  return d;
}

Matrix6 difference_by_step(const Pose& pose, const Pose& origin) noexcept {
  const Vector6 d = pose_difference(pose, origin);
  // The step turns about the pose's own place, the difference about the origin's.
  Matrix6 shift = Matrix6::Identity();
  shift.bottomLeftCorner<3, 3>() = cross_matrix(pose.translation - origin.translation);
  Matrix6 screw = Matrix6::Zero();
  screw.topLeftCorner<3, 3>() = cross_matrix(d.head<3>());
  screw.bottomRightCorner<3, 3>() = cross_matrix(d.head<3>());
  screw.bottomLeftCorner<3, 3>() = cross_matrix(d.tail<3>());
  return (Matrix6::Identity() - 0.5 * screw + screw * screw / 12.0) * shift;
}

double gaussian_cost(const Vector6& difference, const Matrix6& covariance) noexcept {
  const Eigen::LLT<Matrix6> factor(covariance);
  if (factor.info() != Eigen::Success) return kInfinity;
  double log_determinant = 0.0;
  for (int k = 0; k < 6; ++k) log_determinant += 2.0 * std::log(factor.matrixLLT()(k, k));
  return factor.matrixL().solve(difference).squaredNorm() + log_determinant;
}

Eigen::Matrix3d point_covariance(const Pose& world_from_body, const Matrix6& covariance,
                                 const Eigen::Vector3d& point_in_body, double point_sd_m) noexcept {
  Eigen::Matrix<double, 3, 6> by_pose;
  by_pose.leftCols<3>() = -cross_matrix(world_from_body.rotation * point_in_body);
  by_pose.rightCols<3>().setIdentity();
  return by_pose * covariance * by_pose.transpose() + point_sd_m * point_sd_m * Eigen::Matrix3d::Identity();
}

std::optional<BodyFit> fit_body_pose(std::span<const Eigen::Vector3d> markers_in_body,
                                     std::span<const BodyView> views, const Pose& start,
                                     const PosePrior* prior, const BodyFitOptions& options,
                                     std::span<std::uint8_t> outlier) noexcept {
  GLINT_CHECK(markers_in_body.size() <= kBodyMarkers && views.size() <= kMaxViews);
  GLINT_CHECK(outlier.size() == views.size());
  Problem p{markers_in_body, views, prior, options, Matrix6::Zero()};
  if (prior != nullptr) {
    const Eigen::LDLT<Matrix6> factor(prior->covariance);
    if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
    p.prior_information = factor.solve(Matrix6::Identity());
  }
  std::array<double, kMaxViews> room;
  const std::span<double> weights(room.data(), views.size());
  std::fill(weights.begin(), weights.end(), 1.0);

  Pose pose = start;
  Linear at;
  if (!minimise(p, weights, pose, at) || mark_outliers(p, pose, weights) > 0) {
    // Something does not belong here, and it may have spoilt the pose: from the start again.
    pose = start;
    for (int round = 0; round < kHuberRounds; ++round) {
      for (std::size_t k = 0; k < views.size(); ++k) {
        const double chi2 = chi2_of(p, views[k], pose);
        weights[k] = chi2 <= kHuberChi2 ? 1.0 : std::sqrt(kHuberChi2 / chi2);
      }
      if (!minimise(p, weights, pose, at)) return std::nullopt;
    }
    for (int round = 0; round < kRefusalRounds && mark_outliers(p, pose, weights) > 0; ++round)
      if (!minimise(p, weights, pose, at)) return std::nullopt;
  }

  BodyFit fit;
  double squares = 0.0;
  for (std::size_t k = 0; k < views.size(); ++k) {
    outlier[k] = weights[k] == 0.0 ? 1 : 0;
    if (outlier[k] != 0) {
      ++fit.outliers;
      continue;
    }
    ++fit.views;
    const Observation seen{views[k].camera, views[k].normalized, views[k].covariance_px2};
    squares +=
        reprojection_residual_px(seen, pose * markers_in_body[views[k].marker], options.marker_radius_m)
            .squaredNorm();
  }
  const Eigen::LDLT<Matrix6> factor(at.information);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
  fit.covariance = factor.solve(Matrix6::Identity());
  fit.covariance = 0.5 * (fit.covariance + fit.covariance.transpose()).eval();
  if (prior == nullptr &&
      !(fit.covariance.topLeftCorner<3, 3>().trace() < kLargestTurnSd_rad * kLargestTurnSd_rad))
    return std::nullopt;
  fit.world_from_body = pose;
  fit.prior_chi2 = at.prior_chi2;
  fit.chi2 = at.cost - at.prior_chi2;
  fit.rms_px = fit.views == 0 ? 0.0 : std::sqrt(squares / fit.views);
  return fit;
}

}  // namespace glint
