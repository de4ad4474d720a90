// SPDX-License-Identifier: MIT
// Flight of the markers: balls thrown in gravity that bounce for ever, in closed form.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "host/sim/options.hpp"

namespace glint::sim {

/// Where markers may be: x and y within +-1.5 m, z between floor and ceiling. World: z up, origin on the
/// floor.
struct Volume {
  double half_width_m = 1.5;
  double floor_m = 0.0;
  double ceiling_m = 2.0;
};

inline constexpr double kGravity_m_s2 = 9.81;

struct MarkerState {
  Eigen::Vector3d position_in_world, velocity_in_world;
};

/// One ball. Walls, floor and ceiling reflect without loss, so position is a function of time that needs no
/// history: a triangle wave across, repeated parabolas up and down. Balls pass through one another.
class Flight {
 public:
  /// Where the ball's centre turns back.
  struct Range {
    double low = 0.0, high = 0.0;
  };
  Flight(Range x, Range y, Range z, const Eigen::Vector3d& start, const Eigen::Vector3d& speed);

  MarkerState at(double time_s) const noexcept;
  /// Fastest that it ever is: just above its floor.
  double top_speed_m_s() const noexcept { return speed_.norm(); }

 private:
  Range x_, y_, z_;
  Eigen::Vector3d start_;  // x, y in m; z: phase in s of the up-and-down period
  Eigen::Vector3d speed_;  // x, y in m/s; z: upward at the floor
  double rise_s_ = 0.0;    // from the floor to the ceiling or the top of the parabola; 0: hangs still
  double still_z_m_ = 0.0;
};

/// The flights of all markers; top speeds between half of max_speed_m_s and max_speed_m_s, the first at the
/// limit.
std::vector<Flight> throw_markers(const SimOptions& options, const Volume& volume);

}  // namespace glint::sim
