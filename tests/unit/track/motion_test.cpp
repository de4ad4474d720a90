// SPDX-License-Identifier: MIT
// The filter's covariance is honest on motion of the kind that it models.
#include "host/track/motion.hpp"

#include <gtest/gtest.h>

#include <random>

namespace glint {
namespace {

TEST(Motion, InnovationsAreAsLargeAsClaimed) {
  // Normalised innovation squared (Bar-Shalom et al., 5.4.2): its mean is the number of degrees of freedom.
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  const double dt = 1.0 / 90, acceleration = 30.0, sigma = 2e-4;
  const Eigen::Matrix3d r = sigma * sigma * Eigen::Matrix3d::Identity();
  double sum = 0.0;
  int count = 0;
  for (int run = 0; run < 50; ++run) {
    Eigen::Vector3d x = Eigen::Vector3d::Zero(), v(normal(random), normal(random), normal(random));
    const auto noise = [&](double sd) {
      return Eigen::Vector3d(sd * normal(random), sd * normal(random), sd * normal(random));
    };
    Motion motion(x + noise(sigma), r, 3.0);
    for (int k = 0; k < 100; ++k) {
      const Eigen::Vector3d a = noise(acceleration);
      x += dt * v + 0.5 * dt * dt * a;
      v += dt * a;
      motion.advance(dt, acceleration);
      const Eigen::Vector3d measured = x + noise(sigma);
      if (k > 10) {
        sum += motion.distance2(measured, r);
        ++count;
      }
      motion.correct(measured, r);
    }
    EXPECT_LT((motion.velocity() - v).norm(), 1.0);
  }
  EXPECT_NEAR(sum / count, 3.0, 0.15);
}

TEST(Motion, DependsOnTheTrueTimeStep) {
  Motion once({0, 0, 0}, 1e-8 * Eigen::Matrix3d::Identity(), 5.0);
  once.advance(0.01, 30.0);
  once.correct({0.1, 0, 0}, 1e-8 * Eigen::Matrix3d::Identity());
  EXPECT_NEAR(once.velocity().x(), 10.0, 0.1);
  once.advance(0.05, 30.0);
  EXPECT_NEAR(once.position().x(), 0.6, 0.01);
}

}  // namespace
}  // namespace glint
