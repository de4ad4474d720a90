// SPDX-License-Identifier: MIT
// The body of the person who waves the wand, as far as it hides light.
#pragma once

#include "host/sim/movement.hpp"
#include "host/sim/obstacle.hpp"
#include "host/sim/options.hpp"

namespace glint::sim {

/// Where the person is at one moment.
struct PersonShape {
  Pole torso;
  Capsule head, arm;

  bool blocks(const Eigen::Vector3d& from, const Eigen::Vector3d& to) const noexcept {
    return sim::blocks(torso, from, to) || sim::blocks(head, from, to) || sim::blocks(arm, from, to);
  }
  /// The same person, fatter and higher.
  PersonShape grown(double by_m) const noexcept;
};

/// Follows the middle of the wand at arm's length and walks round it slowly.
class Person {
 public:
  /// The wand's `options.wand_m` and the seed count.
  explicit Person(const SimOptions& options);

  PersonShape at(const Eigen::Vector3d& wand_middle_in_world, double time_s) const noexcept;

 private:
  double distance_m_ = 0.0;  // from the wand's middle to the torso's axis, level
  double phase_rad_ = 0.0, sway_phase_rad_ = 0.0;
};

}  // namespace glint::sim
