// SPDX-License-Identifier: MIT
// Where torso, head and arm are.
#include "host/sim/person.hpp"

#include <cmath>
#include <numbers>

#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

constexpr double kTorsoRadius_m = 0.18, kTorsoHeight_m = 1.5;
constexpr double kHeadRadius_m = 0.11, kHeadHeight_m = 1.64;
constexpr double kShoulderHeight_m = 1.38, kArmRadius_m = 0.05;
constexpr double kHandGap_m = 0.08;   // what the arm ends before the wand's middle
constexpr double kElbowRoom_m = 0.2;  // from the wand's end, turned inwards, to the torso's axis
constexpr double kWalk_rad_s = 0.31;

}  // namespace

PersonShape PersonShape::grown(double by_m) const noexcept {
  PersonShape larger = *this;
  larger.torso.radius_m += by_m, larger.torso.height_m += by_m;
  larger.head.radius_m += by_m, larger.arm.radius_m += by_m;
  return larger;
}

Person::Person(const SimOptions& options) : distance_m_(0.5 * options.wand_m.back() + kElbowRoom_m) {
  Random random(stream_seed(options.seed, Stream::Person));
  phase_rad_ = random.uniform(0.0, 2.0 * std::numbers::pi);
  sway_phase_rad_ = random.uniform(0.0, 2.0 * std::numbers::pi);
}

PersonShape Person::at(const Eigen::Vector3d& wand_middle_in_world, double time_s) const noexcept {
  const double azimuth = phase_rad_ + kWalk_rad_s * time_s + 0.7 * std::sin(0.43 * time_s + sway_phase_rad_);
  const double x = wand_middle_in_world.x() + distance_m_ * std::cos(azimuth);
  const double y = wand_middle_in_world.y() + distance_m_ * std::sin(azimuth);
  const Eigen::Vector3d head(x, y, kHeadHeight_m), shoulder(x, y, kShoulderHeight_m);
  const Eigen::Vector3d reach = wand_middle_in_world - shoulder;
  const Eigen::Vector3d hand = wand_middle_in_world - kHandGap_m * reach.normalized();
  return {
      {x, y, kTorsoRadius_m, kTorsoHeight_m}, {head, head, kHeadRadius_m}, {shoulder, hand, kArmRadius_m}};
}

}  // namespace glint::sim
