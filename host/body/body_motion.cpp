// SPDX-License-Identifier: MIT
// Prediction and correction of a body.
#include "host/body/body_motion.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "host/geometry/rotation.hpp"

namespace glint {
namespace {

constexpr int kTurn = 0, kPlace = 3, kTurnRate = 6, kSpeed = 9, kTurnChange = 12, kSpeedChange = 15;

using Matrix18 = BodyMotion::Matrix18;

void fill(Matrix18& m, int row, int column, const Eigen::Matrix3d& block) noexcept {
  m.block<3, 3>(row, column) = block;
}

void fill_both(Matrix18& m, int row, int column, double value) noexcept {
  const Eigen::Matrix3d block = value * Eigen::Matrix3d::Identity();
  m.block<3, 3>(row, column) = block;
  m.block<3, 3>(column, row) = block;
}

// White noise that drives the second derivative (Bar-Shalom, Li, Kirubarajan, Estimation with Applications to
// Tracking and Navigation, 6.2.3).
void add_noise(Matrix18& q, int place, int rate, int change, double density, double t) noexcept {
  const double power = density * density;
  fill_both(q, place, place, power * t * t * t * t * t / 20.0);
  fill_both(q, place, rate, power * t * t * t * t / 8.0);
  fill_both(q, place, change, power * t * t * t / 6.0);
  fill_both(q, rate, rate, power * t * t * t / 3.0);
  fill_both(q, rate, change, power * t * t / 2.0);
  fill_both(q, change, change, power * t);
}

}  // namespace

void BodyMotionOptions::check(std::vector<std::string>& problems) const {
  if (!(jerk_density > 0.0)) problems.emplace_back("body_motion.jerk_density must be > 0");
  if (!(angular_jerk_density > 0.0)) problems.emplace_back("body_motion.angular_jerk_density must be > 0");
  if (!(speed_sd_m_s > 0.0)) problems.emplace_back("body_motion.speed_sd_m_s must be > 0");
  if (!(turn_rate_sd_rad_s > 0.0)) problems.emplace_back("body_motion.turn_rate_sd_rad_s must be > 0");
  if (!(acceleration_sd_m_s2 > 0.0)) problems.emplace_back("body_motion.acceleration_sd_m_s2 must be > 0");
  if (!(angular_acceleration_sd_rad_s2 > 0.0))
    problems.emplace_back("body_motion.angular_acceleration_sd_rad_s2 must be > 0");
}

BodyMotion::BodyMotion(const Pose& world_from_body, const Matrix6& covariance,
                       const BodyMotionOptions& o) noexcept
    : pose_(world_from_body), covariance_(Matrix18::Zero()) {
  covariance_.topLeftCorner<6, 6>() = covariance;
  fill_both(covariance_, kTurnRate, kTurnRate, o.turn_rate_sd_rad_s * o.turn_rate_sd_rad_s);
  fill_both(covariance_, kSpeed, kSpeed, o.speed_sd_m_s * o.speed_sd_m_s);
  fill_both(covariance_, kTurnChange, kTurnChange,
            o.angular_acceleration_sd_rad_s2 * o.angular_acceleration_sd_rad_s2);
  fill_both(covariance_, kSpeedChange, kSpeedChange, o.acceleration_sd_m_s2 * o.acceleration_sd_m_s2);
}

void BodyMotion::advance(double t, const BodyMotionOptions& options) noexcept {
  if (!(t > 0.0)) return;
  // The turn of an angular velocity that itself turns, to third order in time (Magnus).
  const Eigen::Vector3d turn = angular_velocity_ * t + 0.5 * t * t * angular_acceleration_ +
                               t * t * t / 12.0 * angular_acceleration_.cross(angular_velocity_);
  const Eigen::Matrix3d by_turn = left_jacobian(turn);
  Matrix18 f = Matrix18::Identity();
  fill(f, kTurn, kTurn, rotation_of(turn).toRotationMatrix());
  fill(f, kTurn, kTurnRate, t * by_turn);
  fill(f, kTurn, kTurnChange, 0.5 * t * t * by_turn);
  fill(f, kPlace, kSpeed, t * Eigen::Matrix3d::Identity());
  fill(f, kPlace, kSpeedChange, 0.5 * t * t * Eigen::Matrix3d::Identity());
  fill(f, kTurnRate, kTurnChange, t * Eigen::Matrix3d::Identity());
  fill(f, kSpeed, kSpeedChange, t * Eigen::Matrix3d::Identity());
  Matrix18 q = Matrix18::Zero();
  add_noise(q, kTurn, kTurnRate, kTurnChange, options.angular_jerk_density, t);
  add_noise(q, kPlace, kSpeed, kSpeedChange, options.jerk_density, t);

  pose_.rotation = (rotation_of(turn) * pose_.rotation).normalized();
  pose_.translation += velocity_ * t + 0.5 * t * t * acceleration_;
  angular_velocity_ += t * angular_acceleration_;
  velocity_ += t * acceleration_;
  const Matrix18 half = f * covariance_;
  covariance_.noalias() = half * f.transpose();
  covariance_ += q;
}

void BodyMotion::move_by(const Vector18& error) noexcept {
  pose_ = moved(pose_, error.head<6>());
  angular_velocity_ += error.segment<3>(kTurnRate);
  velocity_ += error.segment<3>(kSpeed);
  angular_acceleration_ += error.segment<3>(kTurnChange);
  acceleration_ += error.segment<3>(kSpeedChange);
}

bool BodyMotion::correct(const Pose& measured, const Matrix6& covariance) noexcept {
  const Matrix6 s = pose_covariance() + covariance;
  const Eigen::LLT<Matrix6> factor(s);
  if (factor.info() != Eigen::Success) return false;
  const Eigen::Matrix<double, 18, 6> gain = factor.solve(covariance_.topRows<6>()).transpose();
  const Vector6 difference = pose_difference(measured, pose_);
  Matrix18 left = Matrix18::Identity();
  left.leftCols<6>() -= gain;
  const Matrix18 half = left * covariance_;
  covariance_.noalias() = half * left.transpose();
  covariance_.noalias() += gain * covariance * gain.transpose();
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  move_by(gain * difference);
  return true;
}

bool BodyMotion::absorb(const Pose& posterior, const Matrix6& covariance) noexcept {
  const Matrix6 prior = pose_covariance();
  const Eigen::LLT<Matrix6> factor(prior);
  if (factor.info() != Eigen::Success) return false;
  // Regression of the whole state on the pose; what is left over the pose does not explain.
  const Eigen::Matrix<double, 18, 6> by_pose = factor.solve(covariance_.topRows<6>()).transpose();
  // The posterior's uncertainty is of steps from itself; here it is wanted of steps from the prediction.
  const Matrix6 by_step = difference_by_step(posterior, pose_);
  const Matrix6 change = by_step * covariance * by_step.transpose() - prior;
  covariance_.noalias() += by_pose * change * by_pose.transpose();
  move_by(by_pose * pose_difference(posterior, pose_));
  const Matrix6 back = by_step.inverse();
  covariance_.topRows<6>() = (back * covariance_.topRows<6>()).eval();
  covariance_.leftCols<6>() = (covariance_.leftCols<6>() * back.transpose()).eval();
  covariance_ = 0.5 * (covariance_ + covariance_.transpose()).eval();
  return true;
}

}  // namespace glint
