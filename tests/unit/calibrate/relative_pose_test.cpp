// SPDX-License-Identifier: MIT
// The pose between two cameras from what both saw: with noise, outliers, ends that look alike and flat
// scenes.
#include "host/calibrate/relative_pose.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>

#include <Eigen/Geometry>

#include "host/sim/random.hpp"

namespace glint::test {
namespace {

constexpr double kFocal_px = 920.0;
constexpr double kNoise = 0.05 / kFocal_px;  // z = 1 plane
constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kScenes = 10;

/// Two cameras a few metres apart that look at the same two metres, as on the walls of a room.
class Scene {
 public:
  explicit Scene(std::uint64_t seed) : random_(seed) {
    const double turn = random_.uniform(0.6, 1.6) * (random_.uniform() < 0.5 ? -1.0 : 1.0);
    const Eigen::Quaterniond rotation =
        Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY()) *
        Eigen::AngleAxisd(random_.uniform(-0.2, 0.2), Eigen::Vector3d::UnitX()) *
        Eigen::AngleAxisd(random_.uniform(-0.1, 0.1), Eigen::Vector3d::UnitZ());
    b_from_a_.rotation = rotation;
    b_from_a_.translation = Eigen::Vector3d(0.0, 0.0, random_.uniform(3.0, 4.0)) - rotation * middle();
  }

  const Pose& b_from_a() const { return b_from_a_; }
  sim::Random& random() { return random_; }
  static Eigen::Vector3d middle() { return {0.0, 0.0, 3.5}; }
  Eigen::Vector3d anywhere() {
    return middle() +
           Eigen::Vector3d(random_.uniform(-1, 1), random_.uniform(-0.7, 0.7), random_.uniform(-1, 1));
  }

  void add(PairTick& tick, const Eigen::Vector3d& point_in_a) {
    tick.points.push_back(static_cast<std::uint32_t>(tick.points.size()));
    tick.a.push_back(point_in_a.hnormalized() + noise());
    tick.b.push_back((b_from_a_ * point_in_a).hnormalized() + noise());
  }
  /// One point at each tick, where `place` says.
  std::vector<PairTick> points(std::size_t count, const std::function<Eigen::Vector3d()>& place) {
    std::vector<PairTick> ticks;
    for (std::size_t t = 0; t < count; ++t) {
      ticks.push_back({t, {}, {}, {}});
      add(ticks.back(), place());
    }
    return ticks;
  }
  std::vector<PairTick> points(std::size_t count) {
    return points(count, [this] { return anywhere(); });
  }

 private:
  Eigen::Vector2d noise() {
    return kNoise * Eigen::Vector2d(static_cast<double>(normal_.draw(random_)),
                                    static_cast<double>(normal_.draw(random_)));
  }
  sim::Random random_;
  sim::NormalTable normal_;
  Pose b_from_a_;
};

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

void expect_near(const RelativePose& found, const Pose& truth, double most_rad) {
  EXPECT_LT(found.b_from_a.rotation.angularDistance(truth.rotation), most_rad);
  EXPECT_LT(angle_between(found.b_from_a.translation, truth.translation), most_rad);
  EXPECT_NEAR(found.b_from_a.translation.norm(), 1.0, 1e-9);
}

TEST(RelativePose, IsFoundWithinAFewHundredthsOfADegree) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    const auto found = relative_pose(scene.points(400), {});
    ASSERT_TRUE(found) << seed;
    expect_near(*found, scene.b_from_a(), 0.05 * kDegree);
    EXPECT_EQ(found->points, 400u);
    EXPECT_EQ(found->inliers, 400u);
    EXPECT_LT(found->planar_share, 0.5);
    EXPECT_GT(found->median_angle_rad, 0.3);
  }
}

TEST(RelativePose, ThirtyPercentOfOutliersDoNoHarm) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    std::vector<PairTick> ticks = scene.points(600);
    for (std::size_t t = 0; t < ticks.size(); ++t) {
      if (t % 10 < 3) ticks[t].b[0] = {scene.random().uniform(-0.6, 0.6), scene.random().uniform(-0.4, 0.4)};
    }
    const auto found = relative_pose(ticks, {});
    ASSERT_TRUE(found) << seed;
    expect_near(*found, scene.b_from_a(), 0.2 * kDegree);
    EXPECT_GE(found->inliers, 420u);
    EXPECT_LE(found->inliers, 450u);  // by chance some lie near their epipolar lines
  }
}

TEST(RelativePose, TellsEndsThatLookAlike) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    std::vector<PairTick> ticks;
    std::vector<std::uint8_t> swapped;
    for (std::uint64_t t = 0; t < 400; ++t) {
      PairTick& tick = ticks.emplace_back();
      tick.tick = t;
      const Eigen::Vector3d first = scene.anywhere();
      scene.add(tick, first);
      scene.add(tick, first + 0.5 * (scene.anywhere() - Scene::middle()).normalized());
      swapped.push_back(scene.random().uniform() < 0.5);
      if (swapped.back() != 0) std::swap(tick.b[0], tick.b[1]);
    }
    RelativePoseOptions options;
    options.ends_alike = true;
    const auto found = relative_pose(ticks, options);
    ASSERT_TRUE(found) << seed;
    expect_near(*found, scene.b_from_a(), 0.05 * kDegree);
    // Where both ends lie in one epipolar plane nothing tells.
    std::size_t wrong = 0;
    ASSERT_EQ(found->swapped.size(), swapped.size());
    for (std::size_t t = 0; t < swapped.size(); ++t) wrong += (found->swapped[t] != 0) != (swapped[t] != 0);
    EXPECT_LE(wrong, 4u) << seed;
  }
}

TEST(RelativePose, AFlatSceneIsKnownAsSuch) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    const Eigen::Vector3d across = Eigen::Vector3d(1.0, scene.random().uniform(-0.3, 0.3), 0.3).normalized(),
                          down = Eigen::Vector3d(0.0, 1.0, scene.random().uniform(-0.3, 0.3)).normalized();
    const auto found = relative_pose(scene.points(400,
                                                  [&]() -> Eigen::Vector3d {
                                                    return Scene::middle() +
                                                           scene.random().uniform(-1.0, 1.0) * across +
                                                           scene.random().uniform(-0.7, 0.7) * down;
                                                  }),
                                     {});
    if (found) {
      EXPECT_GT(found->planar_share, 0.95) << seed;
    }
  }
}

TEST(RelativePose, PointsLieInFrontOfBothCameras) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    std::vector<PairTick> ticks = scene.points(200);
    const auto found = relative_pose(ticks, {});
    ASSERT_TRUE(found);
    const double true_m = scene.b_from_a().translation.norm();
    for (const PairTick& tick : ticks) {
      const auto point = meeting_point(found->b_from_a, tick.a[0], tick.b[0]);
      ASSERT_TRUE(point);
      EXPECT_GT(point->z(), 0.0);
      EXPECT_GT((found->b_from_a * *point).z(), 0.0);
      EXPECT_LT(true_m * point->norm(), 6.0);
    }
  }
}

/// The image of b mirrored, as some cameras do. Cameras side by side have epipolar lines that mirroring
/// hardly changes, so that many points may seem to fit, but never nearly all.
TEST(RelativePose, AMirroredImageFitsNoPose) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    std::vector<PairTick> ticks = scene.points(400);
    for (PairTick& tick : ticks) tick.b[0].x() *= -1.0;
    if (const auto found = relative_pose(ticks, {})) {
      EXPECT_LT(found->inliers, 380u) << seed;
    }
  }
}

TEST(RelativePose, WhatHasNothingInCommonHasNoPose) {
  for (std::uint64_t seed = 1; seed <= kScenes; ++seed) {
    Scene scene(seed);
    std::vector<PairTick> ticks = scene.points(400);
    for (PairTick& tick : ticks)
      tick.b[0] = {scene.random().uniform(-0.6, 0.6), scene.random().uniform(-0.4, 0.4)};
    EXPECT_FALSE(relative_pose(ticks, {})) << seed;
  }
}

TEST(RelativePose, TooFewPointsHaveNoPose) {
  Scene scene(1);
  EXPECT_FALSE(relative_pose({}, {}));
  EXPECT_FALSE(relative_pose(scene.points(15), {}));
  EXPECT_TRUE(relative_pose(scene.points(16), {}));
}

TEST(RelativePose, IsTheSameEveryTime) {
  Scene scene(2);
  const std::vector<PairTick> ticks = scene.points(300);
  const auto once = relative_pose(ticks, {}), again = relative_pose(ticks, {});
  ASSERT_TRUE(once && again);
  EXPECT_EQ(once->b_from_a.rotation.coeffs(), again->b_from_a.rotation.coeffs());
  EXPECT_EQ(once->b_from_a.translation, again->b_from_a.translation);
}

TEST(MeetingPoint, NothingBehindACameraOrWithoutParallax) {
  const Pose b_from_a{Eigen::Quaterniond::Identity(), {-1.0, 0.0, 0.0}};
  const Eigen::Vector3d point(0.3, 0.2, 4.0);
  const auto met = meeting_point(b_from_a, point.hnormalized(), (b_from_a * point).hnormalized());
  ASSERT_TRUE(met);
  EXPECT_LT((*met - point).norm(), 1e-12);
  EXPECT_FALSE(meeting_point(b_from_a, {0.0, 0.0}, {0.1, 0.0})) << "the rays part";
  EXPECT_FALSE(meeting_point(b_from_a, {0.2, 0.1}, {0.2, 0.1})) << "they are parallel";
}

}  // namespace
}  // namespace glint::test
