// SPDX-License-Identifier: MIT
// Pairs of balls touch, part and slide round each other, and never go into each other.
#include "host/sim/touching_pairs.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/sim/scene.hpp"

namespace glint::sim {
namespace {

SimOptions pairs(std::uint32_t markers, std::uint64_t seed) {
  SimOptions options;
  options.motion = SimMotion::Pairs;
  options.markers = markers;
  options.seed = seed;
  return options;
}

TEST(TouchingPairs, NeverNearerThanTouchingAndOftenThere) {
  const SimOptions options = pairs(10, 1);
  const TouchingPairs motion(options, {});
  const double touching = 2.0 * options.marker_radius_m;
  for (std::uint32_t p = 0; p < 5; ++p) {
    int touches = 0, partings = 0, moments = 0;
    bool apart = false;
    for (double t = 0.0; t < 30.0; t += 0.004, ++moments) {
      const double distance = (motion.position(2 * p, t) - motion.position(2 * p + 1, t)).norm();
      ASSERT_GE(distance, touching - 1e-12);
      ASSERT_LE(distance, touching + 0.04 + 1e-12);
      touches += distance < touching + 1e-9 ? 1 : 0;
      partings += distance > touching + 0.02 && !apart ? 1 : 0;
      if (distance > touching + 0.02) apart = true;
      if (distance < touching + 0.001) apart = false;
    }
    EXPECT_GT(touches, moments * 4 / 10);  // while they slide
    EXPECT_LT(touches, moments * 6 / 10);
    EXPECT_GE(partings, 7);  // 30 s of turns of 1 to 2 s, every other one
    EXPECT_LE(partings, 16);
  }
}

TEST(TouchingPairs, SlideRoundEachOtherByHalfATurn) {
  const TouchingPairs motion(pairs(2, 3), {});
  const auto axis = [&](double t) { return (motion.position(0, t) - motion.position(1, t)).normalized(); };
  // Direction of the axis turns by a step's worth of slow turning but for the slides.
  double fastest = 0.0, total = 0.0;
  for (double t = 0.0; t < 30.0; t += 0.005) {
    const double turned = std::acos(std::min(1.0, axis(t).dot(axis(t + 0.005))));
    fastest = std::max(fastest, turned / 0.005), total += turned;
  }
  EXPECT_GT(fastest, 2.0);              // in the middle of a slide
  EXPECT_GT(total, 7 * 3.14159 * 0.9);  // at least 7 slides of half a turn
}

TEST(TouchingPairs, DriftSlowlyInsideAndSmoothly) {
  for (const std::uint32_t markers : {2u, 10u, 100u}) {
    const SimOptions options = pairs(markers, 2);
    const TouchingPairs motion(options, {});
    constexpr double kStep_s = 1e-3;
    double fastest = 0.0;
    for (std::uint32_t p = 0; p < markers / 2; ++p) {
      const auto centre = [&](double t) {
        return (0.5 * (motion.position(2 * p, t) + motion.position(2 * p + 1, t))).eval();
      };
      for (double t = 0.0; t < 20.0; t += 0.02) {
        fastest = std::max(fastest, (centre(t + kStep_s) - centre(t - kStep_s)).norm() / (2.0 * kStep_s));
        for (const std::uint32_t m : {2 * p, 2 * p + 1}) {
          const Eigen::Vector3d before = motion.position(m, t - kStep_s), now = motion.position(m, t),
                                after = motion.position(m, t + kStep_s);
          ASSERT_LE(now.head<2>().cwiseAbs().maxCoeff(), 1.5 - options.marker_radius_m);
          ASSERT_GE(now.z(), options.marker_radius_m);
          ASSERT_LE(now.z(), 2.0 - options.marker_radius_m);
          ASSERT_LT((after - 2.0 * now + before).norm() / (kStep_s * kStep_s), 2.0);
        }
      }
    }
    EXPECT_LE(fastest, 0.3);
    EXPECT_GT(fastest, 0.2);
  }
}

TEST(TouchingPairs, CamerasSeeTheOneBeforeTheOther) {
  // From changing sides: each marker of the pair is hidden by the other in every camera now and then.
  const Scene scene(pairs(2, 1));
  TickTruth truth;
  std::array<std::array<int, 4>, 2> hidden{};
  for (std::uint64_t tick = 0; tick < 90 * 60; tick += 3) {
    scene.truth(tick, truth);
    for (std::uint32_t m = 0; m < 2; ++m) {
      for (std::uint32_t c = 0; c < 4; ++c) hidden[m][c] += (truth.markers[m].visible >> c & 1u) == 0 ? 1 : 0;
    }
  }
  for (const auto& of_marker : hidden) {
    for (const int count : of_marker) EXPECT_GT(count, 20);
  }
}

}  // namespace
}  // namespace glint::sim
