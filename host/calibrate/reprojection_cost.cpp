// SPDX-License-Identifier: MIT
#include "host/calibrate/reprojection_cost.hpp"
#include "host/geometry/rotation.hpp"

#include <Eigen/Geometry>

namespace glint {
namespace {

/// A Jacobian of Ceres as a matrix: row by row.
template <int kRows, int kColumns>
auto jacobian(double* values) {
  return Eigen::Map<Eigen::Matrix<double, kRows, kColumns, Eigen::RowMajor>>(values);
}

/// What all sightings share: residuals, and derivatives by the camera's three blocks. False if the point is
/// not in front of the camera. `pixel_by_world` is the derivative by the point, over sigma.
bool evaluate(const SightingTerms& terms, const Eigen::Vector3d& point_in_world, double const* const* blocks,
              double* residuals, double** jacobians, Eigen::Matrix<double, 2, 3>& pixel_by_world) {
  const Eigen::Map<const Eigen::Quaterniond> rotation(blocks[0]);
  const Eigen::Map<const Eigen::Vector3d> translation(blocks[1]);
  PredictedSighting seen;
  if (!predict_sighting(blocks[2], rotation * point_in_world + translation, terms.marker_radius_m, seen))
    return false;
  const double weight = 1.0 / terms.sigma_px;
  Eigen::Map<Eigen::Vector2d>(residuals, 2) = weight * (seen.pixel - terms.pixel);
  if (jacobians == nullptr) return true;
  const Eigen::Matrix<double, 2, 3> by_camera = weight * seen.by_point_in_camera;
  pixel_by_world = by_camera * rotation.toRotationMatrix();
  if (jacobians[0] != nullptr)
    jacobian<2, 4>(jacobians[0]) = by_camera * rotated_by_quaternion(rotation, point_in_world);
  if (jacobians[1] != nullptr) jacobian<2, 3>(jacobians[1]) = by_camera;
  if (jacobians[2] != nullptr) jacobian<2, 9>(jacobians[2]) = weight * seen.by_intrinsics;
  return true;
}

}  // namespace

Eigen::Matrix<double, 3, 4> rotated_by_quaternion(const Eigen::Quaterniond& q, const Eigen::Vector3d& p) {
  const Eigen::Vector3d u = q.vec();
  Eigen::Matrix<double, 3, 4> by_q;
  by_q.leftCols<3>() = -2.0 * q.w() * cross_matrix(p) + 2.0 * (u.dot(p) * Eigen::Matrix3d::Identity() +
                                                               u * p.transpose() - 2.0 * p * u.transpose());
  by_q.col(3) = 2.0 * u.cross(p);
  return by_q;
}

PoseBlock pose_block(const Pose& pose) {
  const Eigen::Quaterniond q = pose.rotation.normalized();
  const Eigen::Vector3d& t = pose.translation;
  return {q.x(), q.y(), q.z(), q.w(), t.x(), t.y(), t.z()};
}

Pose pose_of(const double* block) {
  return {Eigen::Quaterniond(block).normalized(), Eigen::Vector3d(block + 4)};
}

template <int kTarget>
bool PointCost<kTarget>::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  const Eigen::Vector3d point = Eigen::Map<const Eigen::Vector3d>(blocks[3] + 3 * point_);
  Eigen::Matrix<double, 2, 3> by_world;
  if (!evaluate(terms_, point, blocks, residuals, jacobians, by_world)) return false;
  if (jacobians != nullptr && jacobians[3] != nullptr) {
    auto by_target = jacobian<2, kTarget>(jacobians[3]);
    by_target.setZero();
    by_target.template middleCols<3>(3 * point_) = by_world;
  }
  return true;
}

bool BoardCost::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  const Eigen::Map<const Eigen::Quaterniond> rotation(blocks[3]);
  const Eigen::Map<const Eigen::Vector3d> translation(blocks[3] + 4);
  Eigen::Matrix<double, 2, 3> by_world;
  if (!evaluate(terms_, rotation * point_in_target_ + translation, blocks, residuals, jacobians, by_world))
    return false;
  if (jacobians != nullptr && jacobians[3] != nullptr) {
    auto by_target = jacobian<2, 7>(jacobians[3]);
    by_target.leftCols<4>() = by_world * rotated_by_quaternion(rotation, point_in_target_);
    by_target.rightCols<3>() = by_world;
  }
  return true;
}

bool ViewCost::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  const Eigen::Map<const Eigen::Quaterniond> rotation(blocks[0]);
  const Eigen::Map<const Eigen::Vector3d> translation(blocks[0] + 4);
  PredictedSighting seen;
  if (!predict_sighting(blocks[1], rotation * point_in_target_ + translation, 0.0, seen)) return false;
  Eigen::Map<Eigen::Vector2d>(residuals, 2) = seen.pixel - pixel_;
  if (jacobians == nullptr) return true;
  if (jacobians[0] != nullptr) {
    auto by_pose = jacobian<2, 7>(jacobians[0]);
    by_pose.leftCols<4>() = seen.by_point_in_camera * rotated_by_quaternion(rotation, point_in_target_);
    by_pose.rightCols<3>() = seen.by_point_in_camera;
  }
  if (jacobians[1] != nullptr) jacobian<2, 9>(jacobians[1]) = seen.by_intrinsics;
  return true;
}

template <int kTarget>
bool LengthCost<kTarget>::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  const Eigen::Vector3d between = Eigen::Map<const Eigen::Vector3d>(blocks[0] + 3 * b_) -
                                  Eigen::Map<const Eigen::Vector3d>(blocks[0] + 3 * a_);
  const double length = between.norm();
  if (!(length > 0.0)) return false;
  residuals[0] = (length - length_m_) / sd_m_;
  if (jacobians != nullptr && jacobians[0] != nullptr) {
    Eigen::Map<Eigen::Matrix<double, 1, kTarget>> by_target(jacobians[0]);
    by_target.setZero();
    const Eigen::RowVector3d direction = between.transpose() / (length * sd_m_);
    by_target.template segment<3>(3 * b_) = direction;
    by_target.template segment<3>(3 * a_) = -direction;
  }
  return true;
}

bool IntrinsicsPrior::Evaluate(double const* const* blocks, double* residuals, double** jacobians) const {
  if (jacobians != nullptr && jacobians[0] != nullptr) jacobian<9, 9>(jacobians[0]).setZero();
  for (int k = 0; k < 9; ++k) {
    const auto i = static_cast<std::size_t>(k);
    const double weight = sd_[i] > 0.0 ? 1.0 / sd_[i] : 0.0;
    residuals[k] = weight * (blocks[0][k] - expected_[i]);
    if (jacobians != nullptr && jacobians[0] != nullptr) jacobians[0][10 * k] = weight;
  }
  return true;
}

template class PointCost<3>;
template class PointCost<6>;
template class PointCost<9>;
template class LengthCost<6>;
template class LengthCost<9>;

}  // namespace glint
