// SPDX-License-Identifier: MIT
// The filter of a body is honest about what it does not know.
#include <gtest/gtest.h>

#include "host/body/body_motion.hpp"
#include "tests/unit/body/body_scene.hpp"

namespace glint {
namespace {

using namespace testing;

Matrix6 diagonal(double turn_rad, double place_m) {
  Matrix6 m = Matrix6::Zero();
  m.diagonal() << Eigen::Vector3d::Constant(turn_rad * turn_rad),
      Eigen::Vector3d::Constant(place_m * place_m);
  return m;
}

/// Moves as the filter's model says, in steps of a 20th of a frame.
struct TrueBody {
  Pose pose;
  Eigen::Vector3d turn_rate, velocity, turn_change = Eigen::Vector3d::Zero(),
                                       acceleration = Eigen::Vector3d::Zero();

  void advance(double seconds, const BodyMotionOptions& o, std::mt19937_64& random) {
    const double t = seconds / 20;
    for (int k = 0; k < 20; ++k) {
      pose.rotation = (rotation_of(t * (turn_rate + 0.5 * t * turn_change)) * pose.rotation).normalized();
      pose.translation += t * velocity + 0.5 * t * t * acceleration;
      turn_rate += t * turn_change;
      velocity += t * acceleration;
      turn_change += normal3(random, o.angular_jerk_density * std::sqrt(t));
      acceleration += normal3(random, o.jerk_density * std::sqrt(t));
    }
  }
};

TEST(BodyMotion, IsHonestWithTrueTimeSteps) {
  std::mt19937_64 random(7);
  BodyMotionOptions options;
  options.angular_jerk_density = 300;  // as far as small angles between frames go
  const double turn_sd = 0.004, place_sd = 0.0004;
  double predicted = 0.0, corrected = 0.0;
  int count = 0;
  for (int run = 0; run < 60; ++run) {
    TrueBody body{random_pose(random), normal3(random, options.turn_rate_sd_rad_s),
                  normal3(random, options.speed_sd_m_s)};
    body.turn_change = normal3(random, options.angular_acceleration_sd_rad_s2);
    body.acceleration = normal3(random, options.acceleration_sd_m_s2);
    const auto measure = [&] {
      return Pose{(rotation_of(normal3(random, turn_sd)) * body.pose.rotation).normalized(),
                  body.pose.translation + normal3(random, place_sd)};
    };
    const Matrix6 covariance = diagonal(turn_sd, place_sd);
    BodyMotion motion(measure(), covariance, options);
    for (int frame = 0; frame < 40; ++frame) {
      const double seconds =
          (uniform(random, 0, 1) < 0.1 ? 2.0 : 1.0) * 0.0111;  // frames are lost now and then
      body.advance(seconds, options, random);
      motion.advance(seconds, options);
      Vector6 error = pose_difference(body.pose, motion.pose());
      predicted += error.dot(motion.pose_covariance().inverse() * error);
      ASSERT_TRUE(motion.correct(measure(), covariance));
      error = pose_difference(body.pose, motion.pose());
      corrected += error.dot(motion.pose_covariance().inverse() * error);
      ++count;
    }
  }
  EXPECT_NEAR(predicted / count, 6.0, 0.5);
  EXPECT_NEAR(corrected / count, 6.0, 0.5);
}

TEST(BodyMotion, FollowsATumblingBodyWithinItsUncertainty) {
  std::mt19937_64 random(8);
  const BodyMotionOptions options;
  const Matrix6 covariance = diagonal(0.002, 0.0002);
  const auto pose_at = [](double t) {
    // 10 m/s and 110 m/s^2 at most, turning at up to 20 rad/s about an axis that turns itself.
    Pose pose;
    pose.translation = {0.9 * std::sin(11.0 * t), 0.4 * std::cos(8.0 * t), 0.8 + 0.2 * std::sin(5.0 * t)};
    pose.rotation = (rotation_of({0, 0, 6.0 * t}) * rotation_of({15.0 * t, 0, 0})).normalized();
    return pose;
  };
  BodyMotion motion(pose_at(0), covariance, options);
  double sum = 0.0, worst = 0.0;
  const double step = 1.0 / 90;
  for (int frame = 1; frame <= 900; ++frame) {
    motion.advance(step, options);
    const Pose truth = pose_at(frame * step);
    const Vector6 error = pose_difference(truth, motion.pose());
    if (frame > 5) {
      sum += error.dot(motion.pose_covariance().inverse() * error) / 895;
      worst = std::max(worst, error.tail<3>().norm() + 0.1 * error.head<3>().norm());
    }
    motion.correct({(rotation_of(normal3(random, 0.002)) * truth.rotation).normalized(),
                    truth.translation + normal3(random, 0.0002)},
                   covariance);
  }
  EXPECT_LT(sum, 6.0);
  EXPECT_GT(sum, 0.6);     // not so wide that it says nothing
  EXPECT_LT(worst, 0.01);  // of a marker 0.1 m from the centre
  EXPECT_LT(std::sqrt(motion.pose_covariance().bottomRightCorner<3, 3>().trace()), 0.001);
}

TEST(BodyMotion, AbsorbingAPosteriorIsCorrecting) {
  std::mt19937_64 random(9);
  const BodyMotionOptions options;
  BodyMotion a(random_pose(random), diagonal(0.01, 0.001), options);
  a.advance(0.01, options);
  BodyMotion b = a;
  const Matrix6 prior = a.pose_covariance(), measured = diagonal(0.002, 0.0003);
  const Vector6 d = 1e-4 * Vector6::Ones();
  const Pose seen{(rotation_of(d.head<3>()) * a.pose().rotation).normalized(),
                  a.pose().translation + d.tail<3>()};
  const Matrix6 posterior = (prior.inverse() + measured.inverse()).inverse();
  const Vector6 shift = posterior * measured.inverse() * d;
  const Pose fitted{(rotation_of(shift.head<3>()) * a.pose().rotation).normalized(),
                    a.pose().translation + shift.tail<3>()};
  ASSERT_TRUE(a.correct(seen, measured));
  ASSERT_TRUE(b.absorb(fitted, posterior));
  EXPECT_LT(pose_difference(a.pose(), b.pose()).norm(), 1e-9);
  EXPECT_LT((a.velocity() - b.velocity()).norm(), 1e-6);
  EXPECT_LT((a.pose_covariance() - b.pose_covariance()).norm(), 1e-12);
  a.advance(0.1, options);
  b.advance(0.1, options);
  EXPECT_LT((a.pose_covariance() - b.pose_covariance()).norm(), 1e-6 * a.pose_covariance().norm());
}

}  // namespace
}  // namespace glint
