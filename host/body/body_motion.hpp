// SPDX-License-Identifier: MIT
// Kalman filter of a body's six degrees of freedom.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/body/body_pose_fit.hpp"

namespace glint {

/// Roots of the power of the white noise that drives acceleration and angular acceleration. The defaults are
/// for anything from a walking person to a drone that tumbles: a marker's acceleration that goes from one
/// limit of 110 m/s^2 to the other within 0.1 s, and a turn of 20 rad/s that changes its axis as quickly.
struct BodyMotionOptions {
  double jerk_density = 200.0;           ///< m/s^2.5
  double angular_jerk_density = 1500.0;  ///< rad/s^2.5
  double speed_sd_m_s = 5.0;             ///< of a body first seen, per axis
  double turn_rate_sd_rad_s = 10.0;
  double acceleration_sd_m_s2 = 40.0;
  double angular_acceleration_sd_rad_s2 = 150.0;
  void check(std::vector<std::string>& problems) const;
};

/// State: position, velocity, acceleration, orientation, angular velocity and acceleration, all in the world;
/// constant acceleration and angular acceleration but for white noise. The error of the orientation is a
/// rotation vector in the world (an error-state filter: Sola, Quaternion kinematics for the error-state
/// Kalman filter, 2017, here with global errors). Of position and orientation together the covariance is
/// kept, so that a body may have its origin anywhere.
class BodyMotion {
 public:
  using Vector18 = Eigen::Matrix<double, 18, 1>;
  using Matrix18 = Eigen::Matrix<double, 18, 18>;

  BodyMotion() = default;
  /// A body first seen.
  BodyMotion(const Pose& world_from_body, const Matrix6& covariance,
             const BodyMotionOptions& options) noexcept;

  void advance(double seconds, const BodyMotionOptions& options) noexcept;
  /// A measurement that owes nothing to this filter. False, and nothing changes, if the covariances are none.
  bool correct(const Pose& measured, const Matrix6& covariance) noexcept;
  /// A pose that was fitted with pose() and pose_covariance() as its prior: velocities learn from it what
  /// they are correlated with. It may hold any amount of information, even about some directions only.
  bool absorb(const Pose& posterior, const Matrix6& covariance) noexcept;

  const Pose& pose() const noexcept { return pose_; }
  /// Rotation vector in the world, then translation.
  Matrix6 pose_covariance() const noexcept { return covariance_.topLeftCorner<6, 6>(); }
  const Eigen::Vector3d& angular_velocity() const noexcept { return angular_velocity_; }
  const Eigen::Vector3d& velocity() const noexcept { return velocity_; }

 private:
  void move_by(const Vector18& error) noexcept;

  Pose pose_;
  Eigen::Vector3d angular_velocity_ = Eigen::Vector3d::Zero(), velocity_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_acceleration_ = Eigen::Vector3d::Zero(), acceleration_ = Eigen::Vector3d::Zero();
  // Orientation, position, angular velocity, velocity, angular acceleration, acceleration.
  Matrix18 covariance_ = Matrix18::Identity();
};

}  // namespace glint
