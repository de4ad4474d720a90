// SPDX-License-Identifier: MIT
// Rigid bodies that swing and turn as wildly as the options allow, in closed form.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "host/sim/body_shapes.hpp"
#include "host/sim/movement.hpp"

namespace glint::sim {

/// Each body has a part of the volume of its own, so that no two meet. Its centre swings to and fro there, in
/// plan as a pendulum whose plane turns, and up and down; the body spins meanwhile. Rates are such that the
/// first body's markers come up to max_speed_m_s and bodies.max_acceleration_m_s2 and never beyond; the
/// others take 1 to 1.6 times as long for the same.
class Tumbling final : public BodyMovement {
 public:
  /// Throws Error if the bodies have no room.
  Tumbling(const SimOptions& options, const Volume& volume);

  Pose world_from_body(std::uint32_t body, double time_s) const noexcept override;

 private:
  /// In plan two circles run in opposite directions, in height one oscillation.
  struct Swing {
    Eigen::Vector3d centre_in_world;
    double forth_m = 0.0, back_m = 0.0, up_m = 0.0;
    double forth_rad_s = 0.0, back_rad_s = 0.0, up_rad_s = 0.0;
    double forth_rad = 0.0, back_rad = 0.0, up_rad = 0.0;
    Spin spin;
  };
  std::vector<Swing> swings_;
};

}  // namespace glint::sim
