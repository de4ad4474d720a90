// SPDX-License-Identifier: MIT
// How near two bodies come, and how far aside they must pass.
#include "host/sim/crossing.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/base/error.hpp"
#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kMostElevation_rad = 0.5;
// Rounds within kCrossings periods: odd, or prime to one another, so that nothing repeats before.
constexpr std::array<int, 3> kDriftRounds{23, 29, 17};
constexpr int kAzimuthRounds = 97, kElevationRounds = 41;
constexpr std::array<int, 2> kSpinRounds{149, -131}, kSlowSpinRounds{-83, 71};

/// From 0 to 1 with no jump of velocity or acceleration at either end; flat beyond.
double eased(double share) noexcept {
  share = std::clamp(share, 0.0, 1.0);
  return share * share * share * (10.0 + share * (6.0 * share - 15.0));
}

}  // namespace

Crossing::Crossing(const SimOptions& options, const Volume& volume)
    : BodyMovement(body_shapes(options)), period_s_(options.bodies.crossing_period_s) {
  const SimBodies& bodies = options.bodies;
  // A quarter of a period before and after they meet they are still out of each other's reach.
  const double farthest_aside_m = bodies.size_m + bodies.closest_m;
  swing_m_ = std::max(0.6, 1.6 * farthest_aside_m);
  const double around_m = 0.5 * (bodies.size_m + farthest_aside_m) + options.marker_radius_m + 0.02;
  const double across_m = volume.half_width_m - 0.5 * swing_m_ - around_m;
  const double half_height_m = 0.5 * (volume.ceiling_m - volume.floor_m);
  const double up_m = half_height_m - 0.5 * swing_m_ * std::sin(kMostElevation_rad) - around_m;
  if (across_m <= 0.0 || up_m <= 0.0) {
    throw Error("simulated rig: no room for crossing bodies of that size: give smaller ones");
  }
  middle_in_world_ = {0.0, 0.0, volume.floor_m + half_height_m};
  drift_m_ = {across_m, across_m, up_m};
  Random random(stream_seed(options.seed, Stream::Motion));
  for (double& phase : drift_rad_) phase = random.uniform(0.0, kTurn);
  azimuth_rad_ = random.uniform(0.0, kTurn);
  elevation_rad_ = random.uniform(0.0, kTurn);
  const double round_rad_s = kTurn / (static_cast<double>(kCrossings) * period_s_);
  for (std::size_t b = 0; b < spins_.size(); ++b) {
    spins_[b] = {kSpinRounds[b] * round_rad_s, kSlowSpinRounds[b] * round_rad_s, random.uniform(0.0, kTurn),
                 random.uniform(0.0, kTurn), any_attitude(random)};
  }
  for (std::size_t n = 0; n < kCrossings; ++n) {
    offsets_m_.push_back(find_offset(n, bodies.closest_m, options.seed));
  }
}

double Crossing::angle(int rounds, double time_s) const noexcept {
  return kTurn * rounds * time_s / (static_cast<double>(kCrossings) * period_s_);
}

Crossing::Directions Crossing::directions(double time_s) const noexcept {
  const double azimuth = angle(kAzimuthRounds, time_s) + azimuth_rad_;
  const double elevation = kMostElevation_rad * std::sin(angle(kElevationRounds, time_s) + elevation_rad_);
  const Eigen::Vector3d along(std::cos(elevation) * std::cos(azimuth),
                              std::cos(elevation) * std::sin(azimuth), std::sin(elevation));
  const Eigen::Vector3d level(-std::sin(azimuth), std::cos(azimuth), 0.0);
  return {along, level, along.cross(level)};
}

/// Constant for a quarter of a period before and after each crossing.
Eigen::Vector2d Crossing::offset_m(double periods) const noexcept {
  const double before = std::floor(periods - 0.5);  // number of the last crossing
  const double first = before - static_cast<double>(kCrossings) * std::floor(before / kCrossings);
  const auto last = std::min(static_cast<std::size_t>(first), kCrossings - 1);
  const Eigen::Vector2d& from = offsets_m_[last];
  const Eigen::Vector2d& to = offsets_m_[(last + 1) % kCrossings];
  return from + eased(2.0 * (periods - 0.5 - before) - 0.5) * (to - from);
}

/// How far aside in a random direction, so that the markers that come nearest just keep their distance. Of
/// two markers at v from each other without offset, that is where |v + h aside| = closest: a quadratic
/// equation for h, of which the outermost solution counts.
Eigen::Vector2d Crossing::find_offset(std::size_t crossing, double closest_m, std::uint64_t seed) const {
  constexpr int kMoments = 96, kDirections = 64;
  struct Moment {
    Directions directions;
    std::vector<Eigen::Vector3d> between;  // markers of the two, without offset
  };
  std::vector<Moment> moments;
  for (int i = 0; i <= kMoments; ++i) {
    const double periods = static_cast<double>(crossing) + 0.25 + 0.5 * i / kMoments;
    const double time_s = periods * period_s_;
    Moment moment{directions(time_s), {}};
    const Eigen::Vector3d centres = swing_m_ * std::cos(0.5 * kTurn * periods) * moment.directions.along;
    const Eigen::Quaterniond first = spins_[0].at(time_s), second = spins_[1].at(time_s);
    for (const Eigen::Vector3d& a : body_markers(0)) {
      for (const Eigen::Vector3d& b : body_markers(1)) {
        moment.between.push_back(centres + first * a - second * b);
      }
    }
    moments.push_back(std::move(moment));
  }
  Random random(stream_seed(seed, Stream::Crossings, crossing));
  for (int i = 0; i < kDirections; ++i) {
    const double angle = random.uniform(0.0, kTurn), c = std::cos(angle), s = std::sin(angle);
    std::optional<double> outermost;
    for (const Moment& moment : moments) {
      const Eigen::Vector3d aside = c * moment.directions.level + s * moment.directions.steep;
      for (const Eigen::Vector3d& between : moment.between) {
        const double there = between.dot(aside);
        const double rest = closest_m * closest_m - (between.squaredNorm() - there * there);
        if (rest > 0.0) outermost = std::max(outermost.value_or(-1e9), std::sqrt(rest) - there);
      }
    }
    if (outermost) return *outermost * Eigen::Vector2d(c, s);
  }
  throw Error(
      "simulated rig: the crossing bodies' markers never come as near as bodies.closest_m: give a larger "
      "one");
}

Pose Crossing::world_from_body(std::uint32_t body, double time_s) const noexcept {
  const double periods = time_s / period_s_;
  const Directions directions = this->directions(time_s);
  const Eigen::Vector2d offset = offset_m(periods);
  const Eigen::Vector3d between = swing_m_ * std::cos(0.5 * kTurn * periods) * directions.along +
                                  offset.x() * directions.level + offset.y() * directions.steep;
  Eigen::Vector3d centre = middle_in_world_;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const int rounds = kDriftRounds[static_cast<std::size_t>(axis)];
    centre[axis] += drift_m_[axis] * std::sin(angle(rounds, time_s) + drift_rad_[axis]);
  }
  return {spins_[body].at(time_s), centre + (body == 0 ? 0.5 : -0.5) * between};
}

}  // namespace glint::sim
