// SPDX-License-Identifier: MIT
// Constant-velocity Kalman filter of one marker.
#pragma once

#include <Eigen/Core>

namespace glint {

/// Position and velocity with their covariance, in the world.
class Motion {
 public:
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  using Matrix6 = Eigen::Matrix<double, 6, 6>;

  /// A marker first seen: its velocity is zero within velocity_sd_m_s per axis.
  Motion(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance_m2,
         double velocity_sd_m_s) noexcept;

  /// White acceleration, constant within the step (Bar-Shalom, Li, Kirubarajan, Estimation with Applications
  /// to Tracking and Navigation, 6.3.2).
  void advance(double seconds, double acceleration_sd_m_s2) noexcept;
  /// Squared Mahalanobis distance of a measured position, three degrees of freedom.
  double distance2(const Eigen::Vector3d& measured, const Eigen::Matrix3d& covariance_m2) const noexcept;
  /// Joseph form, so that the covariance stays symmetric and positive.
  void correct(const Eigen::Vector3d& measured, const Eigen::Matrix3d& covariance_m2) noexcept;
  /// The velocity has just changed by up to about this: it is learnt anew.
  void loosen_velocity(double sd_m_s) noexcept;

  Eigen::Vector3d position() const noexcept { return state_.head<3>(); }
  Eigen::Vector3d velocity() const noexcept { return state_.tail<3>(); }
  Eigen::Matrix3d position_covariance() const noexcept { return covariance_.topLeftCorner<3, 3>(); }

 private:
  Vector6 state_;
  Matrix6 covariance_;
};

}  // namespace glint
