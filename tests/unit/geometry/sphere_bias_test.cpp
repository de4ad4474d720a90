// SPDX-License-Identifier: MIT
// The closed form against a sphere's outline traced numerically.
#include "host/geometry/sphere_bias.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include <Eigen/Geometry>

namespace glint {
namespace {

/// Mean of the z = 1 plane over the inside of the tangent cone, from its outline by Green's theorem.
Eigen::Vector2d traced_centre(const Eigen::Vector3d& centre, double radius) {
  const double d = centre.norm(), alpha = std::asin(radius / d);
  const Eigen::Vector3d axis = centre / d, side = axis.unitOrthogonal(), other = axis.cross(side);
  constexpr int kSteps = 20000;
  const auto outline = [&](int k) {
    const double phi = 2 * M_PI * k / kSteps;
    const Eigen::Vector3d ray =
        std::cos(alpha) * axis + std::sin(alpha) * (std::cos(phi) * side + std::sin(phi) * other);
    return Eigen::Vector2d(ray.x() / ray.z(), ray.y() / ray.z());
  };
  double area = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  const Eigen::Vector2d first = outline(0);
  for (int k = 0; k < kSteps; ++k) {
    const Eigen::Vector2d p = outline(k) - first, q = outline(k + 1) - first;
    const double cross = p.x() * q.y() - p.y() * q.x();
    area += cross;
    moment += cross * (p + q) / 3.0;
  }
  return first + moment / area;
}

TEST(SphereBias, IsTheCentreOfTheTangentConesEllipse) {
  for (double radius : {0.0063, 0.02, 0.1})
    for (double depth : {0.5, 1.0, 3.0})
      for (double x : {-0.7, 0.0, 0.4})
        for (double y : {-0.3, 0.5}) {
          const Eigen::Vector3d centre(x * depth, y * depth, depth);
          const Eigen::Vector2d expected = traced_centre(centre, radius), image(x, y);
          EXPECT_LT((image * sphere_bias_factor(radius, depth) - expected).norm(), 1e-8);
          EXPECT_LT((remove_sphere_bias(expected, radius, depth) - image).norm(), 1e-8);
        }
}

TEST(SphereBias, HasTheKnownSizes) {
  // f = 914 px, 35 degrees off the axis; range to the centre.
  const auto bias_px = [](double radius, double range) {
    const double t = 35 * M_PI / 180;
    return 914 * std::tan(t) * (sphere_bias_factor(radius, range * std::cos(t)) - 1.0);
  };
  EXPECT_NEAR(bias_px(0.00635, 2.0), 0.010, 0.001);
  EXPECT_NEAR(bias_px(0.0095, 1.0), 0.086, 0.002);
  EXPECT_NEAR(bias_px(0.02, 1.0), 0.38, 0.01);
  EXPECT_NEAR(bias_px(0.02, 0.5), 1.5, 0.05);
}

TEST(SphereBias, IsNothingWithoutARadiusOrInsideTheSphere) {
  EXPECT_EQ(sphere_bias_factor(0.0, 1.0), 1.0);
  EXPECT_EQ(sphere_bias_factor(-1.0, 1.0), 1.0);
  EXPECT_EQ(sphere_bias_factor(0.1, 0.05), 1.0);
  EXPECT_EQ(sphere_bias_factor(0.1, -1.0), 1.0);
}

}  // namespace
}  // namespace glint
