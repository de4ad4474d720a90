// SPDX-License-Identifier: MIT
// Where the two balls of a pair are.
#include "host/sim/touching_pairs.hpp"

#include <cmath>
#include <numbers>

#include "host/base/error.hpp"
#include "host/sim/cells.hpp"
#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kDrift_m_s = 0.3;
constexpr double kParted_m = 0.04;  // farther than touching, at most

/// From 0 to 1 with no jump of velocity or acceleration at either end.
double eased(double share) noexcept { return share * share * share * (10.0 + share * (6.0 * share - 15.0)); }

}  // namespace

TouchingPairs::TouchingPairs(const SimOptions& options, const Volume& volume)
    : touching_m_(2.0 * options.marker_radius_m) {
  const std::uint32_t count = options.markers / 2;
  const std::vector<Cell> cell = cells(volume, count);
  // Balls reach out from the pair's centre by half their distance and a radius.
  const double margin_m = 0.5 * (touching_m_ + kParted_m) + options.marker_radius_m;
  for (std::uint32_t p = 0; p < count; ++p) {
    Random random(stream_seed(options.seed, Stream::Motion, p));
    Pair pair;
    pair.centre_in_world = cell[p].centre_in_world;
    pair.drift_m = cell[p].half_m.array() - margin_m;
    if (pair.drift_m.minCoeff() <= 0.0) {
      throw Error("simulated rig: no room for " + std::to_string(count) + " pairs: give fewer markers");
    }
    // Every axis with a third of the speed's square at most.
    pair.drift_rad_s = kDrift_m_s / std::numbers::sqrt3 * pair.drift_m.cwiseInverse();
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      pair.drift_rad_s[axis] *= random.uniform(0.8, 1.0);
      pair.drift_rad[axis] = random.uniform(0.0, 2.0 * kPi);
    }
    pair.turn_s = random.uniform(1.0, 2.0);
    pair.turns_in = random.uniform(0.0, 2.0);
    pair.azimuth_rad_s = random.uniform(0.3, 0.6) * (random.uniform() < 0.5 ? -1.0 : 1.0);
    pair.azimuth_rad = random.uniform(0.0, 2.0 * kPi);
    pair.elevation_rad_s = random.uniform(0.2, 0.4);
    pair.elevation_rad = random.uniform(0.0, 2.0 * kPi);
    pair.lean_rad = random.uniform(0.0, kPi);
    pairs_.push_back(pair);
  }
}

Eigen::Vector3d TouchingPairs::position(std::uint32_t marker, double time_s) const noexcept {
  const Pair& pair = pairs_[marker / 2];
  const double turns = pair.turns_in + time_s / pair.turn_s, over = std::floor(turns), share = turns - over;
  const double pairs_of_turns = std::floor(0.5 * over);
  const bool slides = over - 2.0 * pairs_of_turns > 0.5;  // every other turn
  const double apart = std::sin(kPi * share);
  const double distance_m = touching_m_ + (slides ? 0.0 : kParted_m * apart * apart);
  const double round_rad = kPi * (pairs_of_turns + (slides ? eased(share) : 0.0));

  const double azimuth = pair.azimuth_rad_s * time_s + pair.azimuth_rad;
  const double elevation = 1.2 * std::sin(pair.elevation_rad_s * time_s + pair.elevation_rad);
  const Eigen::Vector3d axis(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                             std::sin(elevation));
  const Eigen::Vector3d level(-std::sin(azimuth), std::cos(azimuth), 0.0), steep = axis.cross(level);
  const Eigen::Vector3d across = std::cos(pair.lean_rad) * level + std::sin(pair.lean_rad) * steep;
  const Eigen::Vector3d direction = std::cos(round_rad) * axis + std::sin(round_rad) * across;

  Eigen::Vector3d centre = pair.centre_in_world;
  for (Eigen::Index i = 0; i < 3; ++i) {
    centre[i] += pair.drift_m[i] * std::sin(pair.drift_rad_s[i] * time_s + pair.drift_rad[i]);
  }
  return centre + (marker % 2 == 0 ? 0.5 : -0.5) * distance_m * direction;
}

}  // namespace glint::sim
