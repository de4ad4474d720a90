// SPDX-License-Identifier: MIT
// Markers fly on parabolas, bounce, stay inside and keep the speed limit.
#include "host/sim/motion.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace glint::sim {
namespace {

class FlightOfAll : public testing::TestWithParam<double> {
 protected:
  SimOptions options() const {
    SimOptions options;
    options.max_speed_m_s = GetParam();
    options.markers = 30;
    return options;
  }
};

TEST_P(FlightOfAll, StaysInsideAndBelowTheSpeedLimit) {
  const SimOptions wanted = options();
  const double r = wanted.marker_radius_m;
  double fastest = 0.0;
  for (const Flight& flight : throw_markers(wanted, {})) {
    for (double t = 0.0; t < 60.0; t += 1.0 / 90.0) {
      const MarkerState state = flight.at(t);
      ASSERT_LE(state.position_in_world.head<2>().cwiseAbs().maxCoeff(), 1.5 - r + 1e-9);
      ASSERT_GE(state.position_in_world.z(), r - 1e-9);
      ASSERT_LE(state.position_in_world.z(), 2.0 - r + 1e-9);
      ASSERT_LE(state.velocity_in_world.norm(), wanted.max_speed_m_s + 1e-9);
      fastest = std::max(fastest, state.velocity_in_world.norm());
    }
  }
  EXPECT_GT(fastest, 0.97 * wanted.max_speed_m_s);
}

TEST_P(FlightOfAll, KeepsItsEnergy) {
  for (const Flight& flight : throw_markers(options(), {})) {
    const auto energy = [&](double t) {
      const MarkerState state = flight.at(t);
      return 0.5 * state.velocity_in_world.squaredNorm() + kGravity_m_s2 * state.position_in_world.z();
    };
    for (double t = 0.0; t < 20.0; t += 0.37) EXPECT_NEAR(energy(t), energy(0.0), 1e-9);
  }
}

TEST_P(FlightOfAll, VelocityIsTheDerivativeBetweenBounces) {
  constexpr double kStep = 1e-5;
  int compared = 0, differing = 0;
  for (const Flight& flight : throw_markers(options(), {})) {
    for (double t = 1.0; t < 6.0; t += 0.013) {
      const Eigen::Vector3d slope =
          (flight.at(t + kStep).position_in_world - flight.at(t - kStep).position_in_world) / (2.0 * kStep);
      ++compared;
      if ((slope - flight.at(t).velocity_in_world).norm() > 1e-6) ++differing;  // a bounce within the step
    }
  }
  EXPECT_LE(differing, compared / 1000);
}

INSTANTIATE_TEST_SUITE_P(Speeds, FlightOfAll, testing::Values(0.5, 3.0, 10.0, 40.0));

TEST(Flight, FallsWithGravityAndBouncesOffTheFloor) {
  // Up at 3 m/s from the floor: back after 2 v / g, as fast as before.
  const Flight flight({-1, 1}, {-1, 1}, {0, 2}, {0, 0, 0}, {0, 0, 3});
  const double period = 2.0 * 3.0 / kGravity_m_s2;
  EXPECT_NEAR(flight.at(period / 2).position_in_world.z(), 9.0 / (2.0 * kGravity_m_s2), 1e-12);
  EXPECT_NEAR(flight.at(0.999999 * period).velocity_in_world.z(), -3.0, 1e-4);
  EXPECT_NEAR(flight.at(1.000001 * period).velocity_in_world.z(), 3.0, 1e-4);
  EXPECT_NEAR((flight.at(0.11).velocity_in_world.z() - flight.at(0.10).velocity_in_world.z()) / 0.01,
              -kGravity_m_s2, 1e-9);
}

TEST(Flight, BouncesOffTheCeilingWhenFastEnough) {
  const Flight flight({-1, 1}, {-1, 1}, {0, 1}, {0, 0, 0}, {0, 0, 8});
  double highest = 0.0;
  for (double t = 0.0; t < 1.0; t += 1e-4) highest = std::max(highest, flight.at(t).position_in_world.z());
  EXPECT_NEAR(highest, 1.0, 1e-3);
}

TEST(Flight, BouncesOffWalls) {
  const Flight flight({-1, 1}, {-1, 1}, {0, 1}, {0.5, 0, 0.3}, {2, 0, 0});
  EXPECT_NEAR(flight.at(0.2).position_in_world.x(), 0.9, 1e-12);
  EXPECT_NEAR(flight.at(0.3).position_in_world.x(), 0.9, 1e-12);
  EXPECT_EQ(flight.at(0.3).velocity_in_world.x(), -2.0);
  EXPECT_EQ(flight.at(0.3).position_in_world.z(), 0.3);  // thrown level with no vertical speed: hangs
}

TEST(Flight, SpeedZeroHangsStill) {
  SimOptions options;
  options.max_speed_m_s = 0.0;
  for (const Flight& flight : throw_markers(options, {})) {
    EXPECT_EQ(flight.at(0.0).position_in_world, flight.at(7.3).position_in_world);
  }
}

}  // namespace
}  // namespace glint::sim
