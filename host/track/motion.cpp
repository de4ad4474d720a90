// SPDX-License-Identifier: MIT
// Prediction and correction of one marker's motion.
#include "host/track/motion.hpp"

#include <Eigen/LU>

namespace glint {

Motion::Motion(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance_m2,
               double velocity_sd_m_s) noexcept
    : state_(Vector6::Zero()), covariance_(Matrix6::Zero()) {
  state_.head<3>() = position;
  covariance_.topLeftCorner<3, 3>() = covariance_m2;
  covariance_.bottomRightCorner<3, 3>() = velocity_sd_m_s * velocity_sd_m_s * Eigen::Matrix3d::Identity();
}

void Motion::advance(double seconds, double acceleration_sd_m_s2) noexcept {
  Matrix6 f = Matrix6::Identity();
  f.topRightCorner<3, 3>() = seconds * Eigen::Matrix3d::Identity();
  state_ = f * state_;
  Eigen::Matrix<double, 6, 3> g;
  g.topRows<3>() = 0.5 * seconds * seconds * Eigen::Matrix3d::Identity();
  g.bottomRows<3>() = seconds * Eigen::Matrix3d::Identity();
  const Matrix6 moved = f * covariance_ * f.transpose();
  covariance_ = moved + acceleration_sd_m_s2 * acceleration_sd_m_s2 * g * g.transpose();
}

double Motion::distance2(const Eigen::Vector3d& measured,
                         const Eigen::Matrix3d& covariance_m2) const noexcept {
  const Eigen::Vector3d d = measured - position();
  const Eigen::Matrix3d s = position_covariance() + covariance_m2;
  return d.dot(s.inverse() * d);
}

void Motion::correct(const Eigen::Vector3d& measured, const Eigen::Matrix3d& covariance_m2) noexcept {
  const Eigen::Matrix3d s = position_covariance() + covariance_m2;
  const Eigen::Matrix<double, 6, 3> gain = covariance_.leftCols<3>() * s.inverse();
  state_ += gain * (measured - position());
  Matrix6 left = Matrix6::Identity();
  left.leftCols<3>() -= gain;
  const Matrix6 kept = left * covariance_ * left.transpose();
  covariance_ = kept + gain * covariance_m2 * gain.transpose();
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
}

void Motion::loosen_velocity(double sd_m_s) noexcept {
  covariance_.bottomRightCorner<3, 3>() += sd_m_s * sd_m_s * Eigen::Matrix3d::Identity();
}

}  // namespace glint
