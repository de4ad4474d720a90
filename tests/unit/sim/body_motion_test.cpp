// SPDX-License-Identifier: MIT
// Rigid bodies stay rigid, keep the limits that they come up to, and meet as closely as asked.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/base/error.hpp"
#include "host/sim/body_shapes.hpp"
#include "host/sim/crossing.hpp"
#include "host/sim/scene.hpp"
#include "host/sim/tumbling.hpp"

namespace glint::sim {
namespace {

SimOptions bodies(SimMotion motion, std::uint32_t count, std::uint64_t seed) {
  SimOptions options;
  options.motion = motion;
  options.seed = seed;
  options.bodies.count = count;
  options.markers = count * options.bodies.markers;
  return options;
}

void expect_inside(const Eigen::Vector3d& point, double radius_m) {
  ASSERT_LE(point.head<2>().cwiseAbs().maxCoeff(), 1.5 - radius_m);
  ASSERT_GE(point.z(), radius_m);
  ASSERT_LE(point.z(), 2.0 - radius_m);
}

TEST(BodyShapes, AnyThreeMarkersTellWhichTheyAre) {
  for (const std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
    const auto shapes = body_shapes(bodies(SimMotion::Tumbling, 8, seed));
    ASSERT_EQ(shapes.size(), 8u);
    for (const auto& shape : shapes) {
      ASSERT_EQ(shape.size(), 5u);
      double largest = 0.0;
      for (std::size_t a = 0; a < shape.size(); ++a) {
        largest = std::max(largest, shape[a].norm());
        for (std::size_t b = 0; b < a; ++b) EXPECT_GE((shape[a] - shape[b]).norm(), kLeastMarkerGap_m);
      }
      EXPECT_NEAR(largest, 0.1, 1e-12);
    }
    EXPECT_GT(distinctness_m(shapes), 0.0015) << seed;
    EXPECT_GT(distinctness_m({shapes[0]}), 0.005) << seed;
  }
}

TEST(BodyShapes, IdenticalBodiesAreAlikeAndTheOthersNot) {
  SimOptions options = bodies(SimMotion::Crossing, 2, 1);
  EXPECT_NE(body_shapes(options)[0], body_shapes(options)[1]);
  options.bodies.identical = true;
  EXPECT_EQ(body_shapes(options)[0], body_shapes(options)[1]);
}

TEST(BodyShapes, TooManyMarkersForTheSizeAreRefused) {
  SimOptions options = bodies(SimMotion::Tumbling, 1, 1);
  options.bodies.size_m = 0.05;
  options.bodies.markers = 12;
  EXPECT_THROW(body_shapes(options), Error);
}

class TumblingLimits : public testing::TestWithParam<std::uint64_t> {};

TEST_P(TumblingLimits, AreReachedAndNeverExceeded) {
  const SimOptions options = bodies(SimMotion::Tumbling, 3, GetParam());
  const Tumbling motion(options, {});
  constexpr double kStep_s = 2e-4;
  double fastest = 0.0, hardest = 0.0;
  for (std::uint32_t m = 0; m < options.markers; ++m) {
    for (double t = 0.0; t < 20.0; t += 0.0017) {
      const Eigen::Vector3d before = motion.position(m, t - kStep_s), now = motion.position(m, t),
                            after = motion.position(m, t + kStep_s);
      expect_inside(now, options.marker_radius_m);
      fastest = std::max(fastest, (after - before).norm() / (2.0 * kStep_s));
      hardest = std::max(hardest, (after - 2.0 * now + before).norm() / (kStep_s * kStep_s));
    }
  }
  EXPECT_LE(fastest, 10.0);
  EXPECT_GT(fastest, 9.0);
  EXPECT_LE(hardest, 110.0 + 1e-5);  // of rounding in second differences
  EXPECT_GT(hardest, 94.0);
}

INSTANTIATE_TEST_SUITE_P(Seeds, TumblingLimits, testing::Values(1, 2, 3));

TEST(Tumbling, KeepsItsLimitsAtAnySpeedAndSize) {
  for (const std::uint32_t count : {1u, 2u, 8u}) {
    for (const double speed : {0.2, 2.0, 40.0}) {
      for (const double acceleration : {5.0, 500.0}) {
        SimOptions options = bodies(SimMotion::Tumbling, count, 7);
        options.max_speed_m_s = speed;
        options.bodies.max_acceleration_m_s2 = acceleration;
        const Tumbling motion(options, {});
        constexpr double kStep_s = 2e-4;
        double fastest = 0.0, hardest = 0.0;
        for (double t = 0.0; t < 6.0; t += 0.0031) {
          for (std::uint32_t m = 0; m < 5; ++m) {
            const Eigen::Vector3d before = motion.position(m, t - kStep_s), now = motion.position(m, t),
                                  after = motion.position(m, t + kStep_s);
            fastest = std::max(fastest, (after - before).norm() / (2.0 * kStep_s));
            hardest = std::max(hardest, (after - 2.0 * now + before).norm() / (kStep_s * kStep_s));
          }
        }
        EXPECT_LE(fastest, speed);
        EXPECT_LE(hardest, acceleration + 1e-5);
        EXPECT_GT(std::max(fastest / speed, hardest / acceleration), 0.8) << count << " " << speed;
      }
    }
  }
}

TEST(Tumbling, BodiesNeverMeet) {
  const SimOptions options = bodies(SimMotion::Tumbling, 8, 3);
  const Tumbling motion(options, {});
  for (double t = 0.0; t < 10.0; t += 0.003) {
    for (std::uint32_t a = 0; a < 8; ++a) {
      for (std::uint32_t b = 0; b < a; ++b) {
        const double apart =
            (motion.world_from_body(a, t).translation - motion.world_from_body(b, t).translation).norm();
        ASSERT_GT(apart, options.bodies.size_m + 2.0 * options.marker_radius_m);
      }
    }
  }
}

TEST(Tumbling, AxesOfTurningChange) {
  const SimOptions options = bodies(SimMotion::Tumbling, 1, 2);
  const Tumbling motion(options, {});
  const auto axis = [&](double t) {
    const Eigen::Quaterniond turn =
        motion.world_from_body(0, t + 1e-4).rotation * motion.world_from_body(0, t).rotation.conjugate();
    return turn.vec().normalized();
  };
  double least = 1.0;
  for (double t = 0.0; t < 2.0; t += 0.01) least = std::min(least, axis(t).dot(axis(0.0)));
  EXPECT_LT(least, 0.6);
}

TEST(Tumbling, SpeedZeroHangsStillAndNoRoomIsSaid) {
  SimOptions options = bodies(SimMotion::Tumbling, 2, 2);
  options.max_speed_m_s = 0.0;
  const Tumbling still(options, {});
  EXPECT_EQ(still.position(3, 0.0), still.position(3, 5.3));
  options.bodies.size_m = 1.0;
  options.bodies.count = 8;
  EXPECT_THROW(Tumbling(options, {}), Error);
}

/// Smallest distance between markers of the two bodies within one period.
double closest_m(const Crossing& motion, int crossing, double period_s) {
  double least = 1e9;
  for (int i = 0; i < 1000; ++i) {
    const double t = (crossing + i / 1000.0) * period_s;
    const Pose a = motion.world_from_body(0, t), b = motion.world_from_body(1, t);
    if ((a.translation - b.translation).norm() > 0.3) continue;
    for (const Eigen::Vector3d& of_a : motion.body_markers(0)) {
      for (const Eigen::Vector3d& of_b : motion.body_markers(1)) {
        least = std::min(least, (a * of_a - b * of_b).norm());
      }
    }
  }
  return least;
}

TEST(Crossing, BodiesPassAsCloselyAsAskedEveryTime) {
  for (const std::uint64_t seed : {1u, 2u}) {
    for (const double period_s : {1.0, 0.7}) {
      SimOptions options = bodies(SimMotion::Crossing, 2, seed);
      options.bodies.identical = true;
      options.bodies.crossing_period_s = period_s;
      const Crossing motion(options, {});
      double least = 1e9, most = 0.0;
      for (int n = 0; n < 257; ++n) {  // and the first one again
        const double near = closest_m(motion, n, period_s);
        least = std::min(least, near), most = std::max(most, near);
      }
      EXPECT_GT(least, 0.95 * options.bodies.closest_m);
      EXPECT_LT(most, 1.05 * options.bodies.closest_m);
    }
  }
}

TEST(Crossing, StaysInsideAndMovesSmoothly) {
  for (const std::uint64_t seed : {1u, 2u, 3u}) {
    const SimOptions options = bodies(SimMotion::Crossing, 2, seed);
    const Crossing motion(options, {});
    constexpr double kStep_s = 1e-3;
    for (double t = 0.0; t < 256.0; t += 0.021) {
      for (std::uint32_t m = 0; m < options.markers; ++m) {
        const Eigen::Vector3d before = motion.position(m, t - kStep_s), now = motion.position(m, t),
                              after = motion.position(m, t + kStep_s);
        expect_inside(now, options.marker_radius_m);
        ASSERT_LT((after - before).norm() / (2.0 * kStep_s), 4.0);
        ASSERT_LT((after - 2.0 * now + before).norm() / (kStep_s * kStep_s), 40.0);
      }
    }
  }
}

TEST(Crossing, WaysAndAttitudesAreOthersEachTime) {
  const SimOptions options = bodies(SimMotion::Crossing, 2, 1);
  const Crossing motion(options, {});
  const auto between = [&](double t) {
    return (motion.world_from_body(0, t).translation - motion.world_from_body(1, t).translation).eval();
  };
  std::vector<Eigen::Vector3d> ways;
  std::vector<Eigen::Quaterniond> attitudes;
  for (int n = 0; n < 100; ++n) {
    ways.push_back((between(n + 0.51) - between(n + 0.49)).normalized());
    attitudes.push_back(motion.world_from_body(0, n + 0.5).rotation.conjugate() *
                        motion.world_from_body(1, n + 0.5).rotation);
  }
  for (std::size_t a = 0; a < ways.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const double way = std::acos(std::clamp(ways[a].dot(ways[b]), -1.0, 1.0));
      EXPECT_GT(std::max(way, attitudes[a].angularDistance(attitudes[b])), 0.05);
    }
  }
}

TEST(BodyScene, TruthHasThePosesOfTheBodies) {
  for (const SimMotion wanted : {SimMotion::Tumbling, SimMotion::Crossing}) {
    const Scene scene(bodies(wanted, 2, 4));
    ASSERT_EQ(scene.bodies(), 2u);
    TickTruth truth;
    for (const std::uint64_t tick : {0u, 33u, 1234u}) {
      scene.truth(tick, truth);
      ASSERT_EQ(truth.world_from_body.size(), 2u);
      for (std::uint32_t m = 0; m < scene.markers(); ++m) {
        const std::uint32_t body = scene.body_of(m).value();
        EXPECT_EQ(body, m / 5);
        const Eigen::Vector3d expected = truth.world_from_body[body] * scene.body_markers(body)[m % 5];
        EXPECT_LT((truth.markers[m].position_in_world - expected).norm(), 1e-12);
      }
    }
  }
  EXPECT_FALSE(Scene({}).body_of(3).has_value());
  TickTruth truth;
  Scene({}).truth(0, truth);
  EXPECT_TRUE(truth.world_from_body.empty());
}

}  // namespace
}  // namespace glint::sim
