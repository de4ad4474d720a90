// SPDX-License-Identifier: MIT
#include "host/sim/wand_dance.hpp"

#include <cmath>
#include <numbers>

#include "host/sim/random.hpp"

namespace glint::sim {

WandDance::WandDance(const SimOptions& options, const Volume& volume) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  const double half_m = 0.5 * options.wand_m.back(), margin_m = half_m + options.marker_radius_m;
  for (const double place : options.wand_m) from_middle_m_.push_back(place - half_m);
  const double half_height_m = 0.5 * (volume.ceiling_m - volume.floor_m);
  centre_in_world_ = {0.0, 0.0, volume.floor_m + half_height_m};
  reach_m_ = {volume.half_width_m - margin_m, volume.half_width_m - margin_m, half_height_m - margin_m};
  // Another wand is waved another way before the same cameras.
  Random random(stream_seed(options.seed, Stream::Motion, static_cast<std::uint32_t>(from_middle_m_.size())));
  const std::array<double, 3> period_s{7.3, 9.1, 5.7};
  for (std::size_t axis = 0; axis < 3; ++axis) {
    rate_rad_s_[axis] = kTurn / (period_s[axis] * random.uniform(0.95, 1.05));
    phase_rad_[axis] = random.uniform(0.0, kTurn);
  }
  for (double& phase : turn_phase_rad_) phase = random.uniform(0.0, kTurn);
}

Eigen::Vector3d WandDance::position(std::uint32_t marker, double time_s) const noexcept {
  Eigen::Vector3d middle = centre_in_world_;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    middle[axis] += reach_m_[axis] * std::sin(rate_rad_s_[i] * time_s + phase_rad_[i]);
  }
  const double azimuth =
      0.9 * time_s + 0.8 * std::sin(0.37 * time_s + turn_phase_rad_[0]) + turn_phase_rad_[1];
  const double elevation =
      0.9 * std::sin(0.71 * time_s + turn_phase_rad_[2]) + 0.5 * std::sin(1.31 * time_s + turn_phase_rad_[3]);
  const Eigen::Vector3d direction(std::cos(elevation) * std::cos(azimuth),
                                  std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  return middle + from_middle_m_[marker] * direction;
}

}  // namespace glint::sim
