// SPDX-License-Identifier: MIT
// Closed-form flight with lossless bounces.
#include "host/sim/motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

/// Position and direction after `travelled` metres between two walls.
void bounce(double low, double high, double travelled, double& position, double& direction) noexcept {
  const double width = high - low;
  double phase = std::fmod(travelled - low, 2.0 * width);
  if (phase < 0.0) phase += 2.0 * width;
  direction = phase < width ? 1.0 : -1.0;
  position = low + (phase < width ? phase : 2.0 * width - phase);
}

}  // namespace

Flight::Flight(Range x, Range y, Range z, const Eigen::Vector3d& start, const Eigen::Vector3d& speed)
    : x_(x), y_(y), z_(z), start_(start), speed_(speed), still_z_m_(start.z()) {
  const double up = speed.z();
  if (up <= 0.0) return;
  // Time until the ceiling, or until the top if that is lower.
  const double rest = up * up - 2.0 * kGravity_m_s2 * (z.high - z.low);
  rise_s_ = (up - std::sqrt(std::max(0.0, rest))) / kGravity_m_s2;
  const double fall =
      std::max(0.0, up * up - 2.0 * kGravity_m_s2 * std::clamp(start.z() - z.low, 0.0, z.high - z.low));
  start_.z() = std::min(rise_s_, (up - std::sqrt(fall)) / kGravity_m_s2);
}

MarkerState Flight::at(double time_s) const noexcept {
  MarkerState state;
  double direction = 1.0;
  bounce(x_.low, x_.high, start_.x() + speed_.x() * time_s, state.position_in_world.x(), direction);
  state.velocity_in_world.x() = direction * speed_.x();
  bounce(y_.low, y_.high, start_.y() + speed_.y() * time_s, state.position_in_world.y(), direction);
  state.velocity_in_world.y() = direction * speed_.y();
  if (rise_s_ <= 0.0) {
    state.position_in_world.z() = still_z_m_;
    state.velocity_in_world.z() = 0.0;
    return state;
  }
  double since_floor = 0.0;  // folded: falling is rising backwards
  bounce(0.0, rise_s_, start_.z() + time_s, since_floor, direction);
  state.position_in_world.z() = z_.low + (speed_.z() - 0.5 * kGravity_m_s2 * since_floor) * since_floor;
  state.velocity_in_world.z() = direction * (speed_.z() - kGravity_m_s2 * since_floor);
  return state;
}

std::vector<Flight> throw_markers(const SimOptions& options, const Volume& volume) {
  const double r = options.marker_radius_m;
  const Flight::Range across{-volume.half_width_m + r, volume.half_width_m - r};
  const double low = volume.floor_m + r, high = volume.ceiling_m - r;
  std::vector<Flight> flights;
  flights.reserve(options.markers);
  for (std::uint32_t m = 0; m < options.markers; ++m) {
    Random random(stream_seed(options.seed, Stream::Motion, m));
    const double top = options.max_speed_m_s * (m == 0 ? 1.0 : random.uniform(0.5, 1.0));
    const double elevation = random.uniform(20.0, 70.0) * std::numbers::pi / 180.0;
    const double azimuth = random.uniform(0.0, 2.0 * std::numbers::pi);
    const Eigen::Vector3d speed(top * std::cos(elevation) * std::cos(azimuth),
                                top * std::cos(elevation) * std::sin(azimuth), top * std::sin(elevation));
    // A slow ball hops on a shelf of its own, so that slow scenes fill the volume too.
    const double hop = speed.z() * speed.z() / (2.0 * kGravity_m_s2);
    const double shelf = hop < high - low ? random.uniform(low, high - hop) : low;
    const Flight::Range z{shelf, high};
    const double start_z = shelf + random.uniform() * std::min(hop, high - shelf);
    flights.emplace_back(across, across, z,
                         Eigen::Vector3d(random.uniform(across.low, across.high),
                                         random.uniform(across.low, across.high), start_z),
                         speed);
  }
  return flights;
}

}  // namespace glint::sim
