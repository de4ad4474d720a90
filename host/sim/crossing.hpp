// SPDX-License-Identifier: MIT
// Two rigid bodies that pass each other closely again and again, in closed form.
#pragma once

#include <array>
#include <vector>

#include <Eigen/Core>

#include "host/sim/body_shapes.hpp"
#include "host/sim/movement.hpp"

namespace glint::sim {

/// The bodies swing through each other's place, once in each period, at its middle, and out again. The line
/// of the swing, the side on which they pass and their attitudes are others every time, while both drift
/// through the volume and turn. Each crossing's offset is such that the smallest distance between a marker of
/// one and a marker of the other is bodies.closest_m. After kCrossings periods all begins anew.
class Crossing final : public BodyMovement {
 public:
  static constexpr std::size_t kCrossings = 256;

  /// Throws Error if the bodies are too large for the volume.
  Crossing(const SimOptions& options, const Volume& volume);

  Pose world_from_body(std::uint32_t body, double time_s) const noexcept override;

 private:
  /// The line of the swing at one moment, and what stands at right angles on it.
  struct Directions {
    Eigen::Vector3d along, level, steep;
  };
  /// `rounds`: within the time until all begins anew.
  double angle(int rounds, double time_s) const noexcept;
  Directions directions(double time_s) const noexcept;
  Eigen::Vector2d offset_m(double periods) const noexcept;
  Eigen::Vector2d find_offset(std::size_t crossing, double closest_m, std::uint64_t seed) const;

  double period_s_ = 1.0, swing_m_ = 0.0;  // swing: largest distance between the centres, along the line
  Eigen::Vector3d middle_in_world_, drift_m_, drift_rad_;
  double azimuth_rad_ = 0.0, elevation_rad_ = 0.0;
  std::array<Spin, 2> spins_;
  std::vector<Eigen::Vector2d> offsets_m_;  // level and steep, of each crossing
};

}  // namespace glint::sim
