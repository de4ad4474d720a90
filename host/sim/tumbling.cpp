// SPDX-License-Identifier: MIT
// Rates of swing and spin from the limits of speed and acceleration.
#include "host/sim/tumbling.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "host/base/error.hpp"
#include "host/sim/cells.hpp"
#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kSpinRatio = 0.6;        // of the slower axis to the faster one
constexpr double kRoundingMargin = 1e-6;  // below the limits

/// What a marker at distance 1 from its body's centre gets from a spin of 1 rad/s. The axis turns at right
/// angles to itself, so the acceleration is that of the matrix [w][w] + [w'], whose norm this is.
double acceleration_of_spin() {
  const double cross = kSpinRatio / (1.0 + kSpinRatio * kSpinRatio);  // |w'| / |w|^2
  return 0.5 * (1.0 + std::sqrt(1.0 + 4.0 * cross * cross));
}

struct Rates {
  double swing_rad_s = 0.0, spin_rad_s = 0.0;
};

/// Swing and spin that together keep both limits. A swing of 1 rad/s has `speed_m` m/s and `push_m` m/s2 at
/// most. The spin takes over what is left of the acceleration once the swing has taken the speed.
Rates rates_within(double max_speed_m_s, double max_acceleration_m_s2, double speed_m, double push_m,
                   double reach_m) {
  constexpr double kLeastShare = 0.1, kMostShare = 0.3;  // of the limits, for the spin
  const double spin_push_m = reach_m * acceleration_of_spin();
  const auto left_over = [&](double spin) {
    const double swing = (max_speed_m_s - reach_m * spin) / speed_m;
    return max_acceleration_m_s2 - swing * swing * push_m - spin * spin * spin_push_m;
  };
  double low = std::min(kLeastShare * max_speed_m_s / reach_m,
                        std::sqrt(kLeastShare * max_acceleration_m_s2 / spin_push_m));
  double high =
      std::min(kMostShare * max_speed_m_s / reach_m, std::sqrt(max_acceleration_m_s2 / spin_push_m));
  if (left_over(low) <= 0.0) {  // the acceleration is all used before the speed is reached
    return {std::sqrt((max_acceleration_m_s2 - low * low * spin_push_m) / push_m), low};
  }
  if (left_over(high) < 0.0) {
    for (int i = 0; i < 60; ++i) {
      const double middle = 0.5 * (low + high);
      (left_over(middle) > 0.0 ? low : high) = middle;
    }
    high = low;
  }
  return {(max_speed_m_s - reach_m * high) / speed_m, high};
}

}  // namespace

Tumbling::Tumbling(const SimOptions& options, const Volume& volume) : BodyMovement(body_shapes(options)) {
  constexpr double kGap_m = 0.02;  // that stays free in each cell, all round
  const std::vector<Cell> cell = cells(volume, bodies());
  for (std::uint32_t b = 0; b < bodies(); ++b) {
    double reach_m = 0.0;
    for (const Eigen::Vector3d& marker : body_markers(b)) reach_m = std::max(reach_m, marker.norm());
    const double margin_m = reach_m + options.marker_radius_m + kGap_m;
    const double plan_m = cell[b].half_m.head<2>().minCoeff() - margin_m,
                 up_m = cell[b].half_m.z() - margin_m;
    if (plan_m <= 0.0 || up_m <= 0.0) {
      throw Error("simulated rig: no room for " + std::to_string(bodies()) +
                  " tumbling bodies of that size: give fewer or smaller ones");
    }
    Random random(stream_seed(options.seed, Stream::Motion, b));
    Swing swing;
    swing.centre_in_world = cell[b].centre_in_world;
    const double forth_share = random.uniform(0.5, 0.7);
    swing.forth_m = forth_share * plan_m, swing.back_m = plan_m - swing.forth_m, swing.up_m = up_m;
    const double back = random.uniform(0.75, 0.93), up = random.uniform(0.6, 0.85);  // of the forth rate
    const double speed_m = std::hypot(swing.forth_m + back * swing.back_m, up * up_m);
    const double push_m = std::hypot(swing.forth_m + back * back * swing.back_m, up * up * up_m);
    const double pace = b == 0 ? 1.0 - kRoundingMargin : 1.0 / random.uniform(1.0, 1.6);
    const Rates rates =
        rates_within(options.max_speed_m_s, options.bodies.max_acceleration_m_s2, speed_m, push_m, reach_m);
    swing.forth_rad_s = pace * rates.swing_rad_s;
    swing.back_rad_s = back * swing.forth_rad_s, swing.up_rad_s = up * swing.forth_rad_s;
    swing.forth_rad = random.uniform(0.0, kTurn), swing.back_rad = random.uniform(0.0, kTurn);
    swing.up_rad = random.uniform(0.0, kTurn);
    swing.spin.about_z_rad_s = pace * rates.spin_rad_s / std::hypot(1.0, kSpinRatio);
    swing.spin.about_y_rad_s = kSpinRatio * swing.spin.about_z_rad_s;
    swing.spin.z_phase_rad = random.uniform(0.0, kTurn), swing.spin.y_phase_rad = random.uniform(0.0, kTurn);
    swing.spin.start = any_attitude(random);
    swings_.push_back(swing);
  }
}

Pose Tumbling::world_from_body(std::uint32_t body, double time_s) const noexcept {
  const Swing& swing = swings_[body];
  const double forth = swing.forth_rad_s * time_s + swing.forth_rad,
               back = swing.back_rad_s * time_s + swing.back_rad, up = swing.up_rad_s * time_s + swing.up_rad;
  return {
      swing.spin.at(time_s),
      swing.centre_in_world + Eigen::Vector3d(swing.forth_m * std::cos(forth) + swing.back_m * std::cos(back),
                                              swing.forth_m * std::sin(forth) - swing.back_m * std::sin(back),
                                              swing.up_m * std::sin(up))};
}

}  // namespace glint::sim
