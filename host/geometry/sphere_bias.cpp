// SPDX-License-Identifier: MIT
// Sphere-projection bias in closed form.
#include "host/geometry/sphere_bias.hpp"

namespace glint {

double sphere_bias_factor(double radius_m, double depth_m) noexcept {
  if (!(radius_m > 0.0) || !(depth_m > radius_m)) return 1.0;
  const double ratio = radius_m / depth_m;
  return 1.0 / (1.0 - ratio * ratio);
}

Eigen::Vector2d remove_sphere_bias(const Eigen::Vector2d& outline_centre, double radius_m,
                                   double depth_m) noexcept {
  return outline_centre / sphere_bias_factor(radius_m, depth_m);
}

}  // namespace glint
