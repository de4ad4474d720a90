// SPDX-License-Identifier: MIT
// Drawing of bodies that can be told apart.
#include "host/sim/body_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <string>

#include "host/base/error.hpp"
#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

constexpr int kDraws = 200, kTries = 20000;

using Shape = std::vector<Eigen::Vector3d>;
using Sides = std::array<double, 3>;  // sorted

void add_triangles(const Shape& shape, std::vector<Sides>& triangles) {
  for (std::size_t a = 0; a < shape.size(); ++a) {
    for (std::size_t b = a + 1; b < shape.size(); ++b) {
      for (std::size_t c = b + 1; c < shape.size(); ++c) {
        Sides sides{(shape[a] - shape[b]).norm(), (shape[b] - shape[c]).norm(), (shape[c] - shape[a]).norm()};
        std::sort(sides.begin(), sides.end());
        triangles.push_back(sides);
      }
    }
  }
}

/// Of the triangles from `first` on, among themselves and against all before; as soon as it is below
/// `enough`, that will do.
double least_difference_m(const std::vector<Sides>& triangles, std::size_t first, double enough) {
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = first; i < triangles.size(); ++i) {
    const Sides& own = triangles[i];
    least = std::min({least, own[1] - own[0], own[2] - own[1]});
    for (std::size_t j = 0; j < i && least > enough; ++j) {
      const Sides& other = triangles[j];
      least = std::min(least, std::max({std::abs(own[0] - other[0]), std::abs(own[1] - other[1]),
                                        std::abs(own[2] - other[2])}));
    }
    if (least <= enough) break;
  }
  return least;
}

Eigen::Vector3d in_ball(Random& random, double radius_m) {
  for (;;) {
    const Eigen::Vector3d point(random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0),
                                random.uniform(-1.0, 1.0));
    if (point.squaredNorm() <= 1.0) return radius_m * point;
  }
}

/// Empty if the markers found no room.
Shape draw_shape(Random& random, const SimBodies& bodies) {
  const double radius_m = 0.5 * bodies.size_m;
  Shape shape;
  for (int i = 0; i < kTries && shape.size() < bodies.markers; ++i) {
    Eigen::Vector3d point = in_ball(random, radius_m);
    if (shape.empty()) point *= radius_m / point.norm();
    const bool free = std::all_of(shape.begin(), shape.end(), [&](const Eigen::Vector3d& other) {
      return (point - other).norm() >= kLeastMarkerGap_m;
    });
    if (free) shape.push_back(point);
  }
  if (shape.size() < bodies.markers) shape.clear();
  return shape;
}

}  // namespace

std::vector<Shape> body_shapes(const SimOptions& options) {
  const SimBodies& bodies = options.bodies;
  std::vector<Shape> shapes;
  std::vector<Sides> known;
  for (std::uint32_t b = 0; b < bodies.count; ++b) {
    if (bodies.identical && b > 0) {
      shapes.push_back(shapes.front());
      continue;
    }
    Random random(stream_seed(options.seed, Stream::Bodies, b));
    Shape best;
    double best_m = -1.0;
    for (int draw = 0; draw < kDraws; ++draw) {
      Shape shape = draw_shape(random, bodies);
      if (shape.empty()) continue;
      std::vector<Sides> triangles = known;
      add_triangles(shape, triangles);
      const double difference_m = least_difference_m(triangles, known.size(), best_m);
      if (difference_m <= best_m) continue;
      best = std::move(shape), best_m = difference_m;
    }
    if (best.empty()) {
      throw Error("simulated rig: " + std::to_string(bodies.markers) +
                  " markers 3 cm apart do not fit into a body of " + std::to_string(bodies.size_m) +
                  " m: give fewer markers or a larger body");
    }
    add_triangles(best, known);
    shapes.push_back(std::move(best));
  }
  return shapes;
}

double distinctness_m(const std::vector<Shape>& bodies) {
  std::vector<Sides> triangles;
  for (const Shape& shape : bodies) add_triangles(shape, triangles);
  return least_difference_m(triangles, 0, 0.0);
}

Eigen::Quaterniond Spin::at(double time_s) const noexcept {
  const double z = 0.5 * (about_z_rad_s * time_s + z_phase_rad),
               y = 0.5 * (about_y_rad_s * time_s + y_phase_rad);
  return Eigen::Quaterniond(std::cos(z), 0.0, 0.0, std::sin(z)) *
         Eigen::Quaterniond(std::cos(y), 0.0, std::sin(y), 0.0) * start;
}

Eigen::Quaterniond any_attitude(Random& random) {
  // Shoemake's uniform random rotations (Graphics Gems III, 1992).
  const double share = random.uniform(), a = random.uniform(0.0, 2.0 * std::numbers::pi),
               b = random.uniform(0.0, 2.0 * std::numbers::pi);
  const double low = std::sqrt(1.0 - share), high = std::sqrt(share);
  return {high * std::cos(b), low * std::sin(a), low * std::cos(a), high * std::sin(b)};
}

}  // namespace glint::sim
