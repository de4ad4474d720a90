// SPDX-License-Identifier: MIT
// How a person waves a wand through the whole volume, in closed form.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "host/sim/movement.hpp"
#include "host/sim/options.hpp"

namespace glint::sim {

/// The middle of the wand runs on a Lissajous figure of periods that have no common multiple, so that it
/// comes by everywhere within a minute, at up to about 1.5 m/s; the wand turns about all axes meanwhile. Both
/// follow from the seed.
class WandDance final : public Movement {
 public:
  /// `options.wand_m` has the places of the markers on the wand.
  WandDance(const SimOptions& options, const Volume& volume);

  Eigen::Vector3d position(std::uint32_t marker, double time_s) const noexcept override;

 private:
  std::vector<double> from_middle_m_;
  Eigen::Vector3d centre_in_world_, reach_m_;
  std::array<double, 3> rate_rad_s_{}, phase_rad_{};
  std::array<double, 4> turn_phase_rad_{};
};

}  // namespace glint::sim
