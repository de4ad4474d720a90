// SPDX-License-Identifier: MIT
// Pairs of balls that touch, part, and slide round each other, in closed form.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/sim/movement.hpp"

namespace glint::sim {

/// Markers 2k and 2k + 1 are a pair. By turns they part by a few centimetres and come back, or go half round
/// each other while they touch; each takes 1 to 2 s, the pair's own time. Their centres are never nearer than
/// a diameter. The pair drifts at up to 0.3 m/s through a part of the volume of its own, and its axis turns.
class TouchingPairs final : public Movement {
 public:
  /// Throws Error if so many pairs have no room.
  TouchingPairs(const SimOptions& options, const Volume& volume);

  Eigen::Vector3d position(std::uint32_t marker, double time_s) const noexcept override;

 private:
  struct Pair {
    Eigen::Vector3d centre_in_world, drift_m, drift_rad_s, drift_rad;
    double turn_s = 1.0;    // of each parting or sliding
    double turns_in = 0.0;  // that are over at time 0
    double azimuth_rad_s = 0.0, azimuth_rad = 0.0, elevation_rad_s = 0.0, elevation_rad = 0.0, lean_rad = 0.0;
  };
  double touching_m_ = 0.0;  // between centres
  std::vector<Pair> pairs_;
};

}  // namespace glint::sim
