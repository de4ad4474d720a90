// SPDX-License-Identifier: MIT
// The person who waves the wand hides its markers, wholly or in part, from one camera after the other.
#include "host/sim/person.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>

#include "host/sim/renderer.hpp"
#include "host/sim/scene.hpp"

namespace glint {
namespace {

SimOptions rod(bool person, std::uint64_t seed = 1) {
  SimOptions options;
  options.motion = SimMotion::Wand;
  options.wand_m = {0.0, 0.589};
  options.markers = 2;
  options.person = person;
  options.seed = seed;
  return options;
}

TEST(Obstacles, CapsulesBlockWhatPassesThroughThem) {
  const sim::Capsule arm{{0, 0, 0}, {0, 0, 1}, 0.1};
  EXPECT_TRUE(sim::blocks(arm, {-1, 0, 0.5}, {1, 0, 0.5}));
  EXPECT_TRUE(sim::blocks(arm, {-1, 0.09, 0.5}, {1, 0.09, 0.5}));
  EXPECT_FALSE(sim::blocks(arm, {-1, 0.11, 0.5}, {1, 0.11, 0.5}));
  EXPECT_FALSE(sim::blocks(arm, {-1, 0, 0.5}, {-0.2, 0, 0.5}));  // ends before
  EXPECT_FALSE(sim::blocks(arm, {0.2, 0, 0.5}, {1, 0, 0.5}));    // begins behind
  EXPECT_TRUE(sim::blocks(arm, {-1, 0, 1.09}, {1, 0, 1.09}));    // the round end
  EXPECT_FALSE(sim::blocks(arm, {-1, 0.08, 1.08}, {1, 0.08, 1.08}));
  EXPECT_TRUE(sim::blocks(arm, {0.05, 0, -1}, {0.05, 0, 2}));  // along the axis
  EXPECT_FALSE(sim::blocks(arm, {0.15, 0, -1}, {0.15, 0, 2}));
  const sim::Capsule head{{1, 2, 3}, {1, 2, 3}, 0.1};
  EXPECT_TRUE(sim::blocks(head, {0, 2.05, 3}, {2, 2.05, 3}));
  EXPECT_FALSE(sim::blocks(head, {0, 2.11, 3}, {2, 2.11, 3}));
}

TEST(Obstacles, CapsulesAreWhatRandomPointsSayTheyAre) {
  // Against the distance of many points of the segment from many points of the axis.
  sim::Random random(3);
  const auto point = [&] {
    return Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
  };
  for (int i = 0; i < 300; ++i) {
    const sim::Capsule capsule{point(), point(), random.uniform(0.05, 0.5)};
    const Eigen::Vector3d from = point(), to = point();
    double least = 1e9;
    constexpr int kSteps = 100;
    for (int a = 0; a <= kSteps; ++a) {
      for (int b = 0; b <= kSteps; ++b) {
        const Eigen::Vector3d on_ray = from + (to - from) * a / kSteps;
        const Eigen::Vector3d on_axis =
            capsule.from_in_world + (capsule.to_in_world - capsule.from_in_world) * b / kSteps;
        least = std::min(least, (on_ray - on_axis).norm());
      }
    }
    if (std::abs(least - capsule.radius_m) < 0.03) continue;
    EXPECT_EQ(sim::blocks(capsule, from, to), least < capsule.radius_m);
  }
}

TEST(Person, HoldsTheWandAndKeepsClearOfItsMarkers) {
  const SimOptions options = rod(true);
  const sim::Person person(options);
  const Scene scene(options);
  for (double t = 0.0; t < 120.0; t += 0.1) {
    const Eigen::Vector3d a = scene.position(0, t), b = scene.position(1, t), middle = 0.5 * (a + b);
    const sim::PersonShape shape = person.at(middle, t);
    EXPECT_NEAR((shape.arm.to_in_world - middle).norm(), 0.08, 1e-9);
    for (const Eigen::Vector3d& marker : {a, b}) {
      EXPECT_GT(std::hypot(marker.x() - shape.torso.x_m, marker.y() - shape.torso.y_m),
                shape.torso.radius_m + options.marker_radius_m);
    }
  }
}

TEST(Person, EveryCameraLosesMarkersOftenAndTwoSeeThemNearlyAlways) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const Scene with(rod(true, seed)), without(rod(false, seed));
    TickTruth hidden, open;
    std::array<std::uint32_t, 4> seen_open{}, seen{};
    int moments = 0, few = 0;
    for (std::uint64_t tick = 0; tick < 60 * 90; tick += 3) {
      with.truth(tick, hidden);
      without.truth(tick, open);
      for (std::uint32_t m = 0; m < 2; ++m) {
        ASSERT_EQ(hidden.markers[m].position_in_world, open.markers[m].position_in_world);
        ASSERT_EQ(hidden.markers[m].visible & ~open.markers[m].visible, 0u);
        ++moments;
        few += std::popcount(hidden.markers[m].visible) < 2 ? 1 : 0;
        for (std::uint32_t c = 0; c < 4; ++c) {
          seen_open[c] += open.markers[m].visible >> c & 1u;
          seen[c] += hidden.markers[m].visible >> c & 1u;
        }
      }
    }
    for (std::uint32_t c = 0; c < 4; ++c) {
      const double lost = 1.0 - double{1.0} * seen[c] / seen_open[c];
      EXPECT_GT(lost, 0.08) << "seed " << seed << " camera " << c;
      EXPECT_LT(lost, 0.30) << "seed " << seed << " camera " << c;
    }
    EXPECT_LT(few, moments * 3 / 100) << seed;
  }
}

TEST(Person, HidesLightInTheImageAsInTheTruth) {
  const Scene with(rod(true)), without(rod(false));
  sim::Renderer hiding(with), open(without);
  TickTruth truth;
  int dark = 0, partly = 0, whole = 0;
  for (std::uint64_t tick = 0; tick < 60 * 90; tick += 30) {
    with.truth(tick, truth);
    for (std::uint32_t c = 0; c < 4; ++c) {
      std::array<int, 2> lost{};
      for (std::uint32_t m = 0; m < 2; ++m) {
        if (!with.may_be_hidden(c, tick, m, truth.views_of(c))) continue;
        with.sample_disc(c, tick, m, with.mid_exposure_s(tick), truth.views_of(c), 100,
                         [&](const Eigen::Vector3d&, bool hidden) { lost[m] += hidden ? 1 : 0; });
      }
      const bool edge = (lost[0] > 0 && lost[0] < 100) || (lost[1] > 0 && lost[1] < 100);
      if (!edge && lost[0] + lost[1] == 0 && tick % 90 != 0) continue;  // so are most: some will do
      const auto sum = [](const std::vector<float>& light) {
        double total = 0.0;
        for (const float value : light) total += static_cast<double>(value);
        return total;
      };
      const double left = sum(hiding.light(c, tick)), all = sum(open.light(c, tick));
      if (lost[0] + lost[1] == 0) {
        EXPECT_NEAR(left, all, 2e-3 * all + 1e-6);
        ++whole;
      } else if (edge) {
        EXPECT_LE(left, all * (1.0 + 2e-3));
        partly += left < 0.98 * all ? 1 : 0;
      } else if (lost[0] + lost[1] == 200) {
        EXPECT_LT(left, 0.02 * all + 1e-6);
        ++dark;
      }
    }
  }
  EXPECT_GT(dark, 5);
  EXPECT_GT(partly, 5);
  EXPECT_GT(whole, 50);
}

}  // namespace
}  // namespace glint
