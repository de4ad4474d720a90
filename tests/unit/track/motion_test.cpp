// SPDX-License-Identifier: MIT
// The filter's covariance is honest on motion of the kinds that it models, and it tells them apart.
#include "host/track/motion.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <random>

namespace glint {
namespace {

constexpr double kStep_s = 1.0 / 90, kUsual_m_s2 = 30.0;

PositionEvidence seen_at(const Eigen::Vector3d& measured, const Eigen::Matrix3d& covariance) {
  return {measured, covariance.inverse(), Eigen::Vector3d::Zero()};
}

class MotionTest : public testing::Test {
 protected:
  Eigen::Vector3d noise(double sd) {
    return sd * Eigen::Vector3d(normal_(random_), normal_(random_), normal_(random_));
  }
  std::mt19937_64 random_{6};
  std::normal_distribution<double> normal_;
  const double sigma_m_ = 2e-4;
  const Eigen::Matrix3d covariance_ = sigma_m_ * sigma_m_ * Eigen::Matrix3d::Identity();
};

// Normalised estimation error squared (Bar-Shalom et al., 5.4.2): its mean is the number of degrees of
// freedom.
TEST_F(MotionTest, PositionsAreAsUncertainAsClaimedWhateverTheMotion) {
  struct Kind {
    const char* name;
    double white_m_s2, jerk_m_s3;
    Eigen::Vector3d lasting;
  };
  for (const Kind& kind :
       {Kind{"coasting", 1.0, 0.0, {0, 0, 0}}, Kind{"thrown", 1.0, 0.0, {0, 0, -9.81}},
        Kind{"turning", 0.0, 1000.0, {30, 0, 0}}, Kind{"pulled about", 120.0, 0.0, {0, 0, 0}}}) {
    double sum = 0.0;
    int count = 0;
    for (int run = 0; run < 50; ++run) {
      Eigen::Vector3d x = Eigen::Vector3d::Zero(), v = noise(1.0), lasting = kind.lasting;
      Motion motion(x + noise(sigma_m_), covariance_, 3.0, kUsual_m_s2);
      for (int k = 0; k < 100; ++k) {
        lasting += kStep_s * noise(kind.jerk_m_s3);
        const Eigen::Vector3d a = lasting + noise(kind.white_m_s2);
        x += kStep_s * v + 0.5 * kStep_s * kStep_s * a;
        v += kStep_s * a;
        motion.advance(kStep_s, kUsual_m_s2);
        motion.correct(seen_at(x + noise(sigma_m_), covariance_));
        if (k < 10) continue;
        const Eigen::Vector3d error = motion.position() - x;
        sum += error.dot(motion.position_covariance().inverse() * error);
        ++count;
      }
    }
    EXPECT_NEAR(sum / count, 3.0, 0.6) << kind.name;
  }
}

TEST_F(MotionTest, ALastingAccelerationIsForeseen) {
  Motion motion({0, 0, 0}, covariance_, 3.0, kUsual_m_s2);
  const Eigen::Vector3d a(0, 0, -110);
  double t = 0.0;
  for (int k = 0; k < 40; ++k) {
    t += kStep_s;
    motion.advance(kStep_s, kUsual_m_s2);
    if (k > 20) {  // coasting would miss by 6.8
      EXPECT_LT((motion.position() - 0.5 * t * t * a).norm(), 3e-3) << k;
    }
    motion.correct(seen_at(0.5 * t * t * a + noise(sigma_m_), covariance_));
  }
}

TEST_F(MotionTest, OneViewHoldsAMarkerAcrossItsRay) {
  // One camera tells x and y, never z.
  Motion motion({0, 0, 0}, covariance_, 0.1, kUsual_m_s2);
  for (int k = 0; k < 20; ++k) {
    motion.advance(kStep_s, kUsual_m_s2);
    motion.correct(seen_at({0.01 * (k + 1), 0, 0}, covariance_));
  }
  PositionEvidence ray;
  ray.information_per_m2.diagonal() << 1.0 / covariance_(0, 0), 1.0 / covariance_(1, 1), 0.0;
  for (int k = 20; k < 30; ++k) {
    motion.advance(kStep_s, kUsual_m_s2);
    ray.near_in_world = {0.01 * (k + 1), 0, 5.0};  // any place on the ray says the same
    motion.correct(ray);
  }
  EXPECT_NEAR(motion.position().x(), 0.30, 5e-4);
  EXPECT_LT(motion.position_covariance()(0, 0), covariance_(0, 0));
  EXPECT_GT(motion.position_covariance()(2, 2), 10 * covariance_(2, 2));
  EXPECT_LT(std::abs(motion.position().z()), 3.0 * std::sqrt(motion.position_covariance()(2, 2)));
}

TEST_F(MotionTest, DependsOnTheTrueTimeStep) {
  Motion once({0, 0, 0}, 1e-8 * Eigen::Matrix3d::Identity(), 5.0, kUsual_m_s2);
  once.advance(0.01, kUsual_m_s2);
  once.correct(seen_at({0.1, 0, 0}, 1e-8 * Eigen::Matrix3d::Identity()));
  EXPECT_NEAR(once.velocity().x(), 10.0, 0.1);
  once.advance(0.05, kUsual_m_s2);
  EXPECT_NEAR(once.position().x(), 0.6, 0.01);
}

}  // namespace
}  // namespace glint
