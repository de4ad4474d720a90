// SPDX-License-Identifier: MIT
// Bodies found anew among unnamed points.
#include <chrono>

#include <gtest/gtest.h>

#include "host/body/body_finder.hpp"
#include "tests/unit/body/body_scene.hpp"

namespace glint {
namespace {

using namespace testing;

struct Crowd {
  std::vector<FinderPoint> points;
  std::vector<std::pair<int, int>> origin;  // body and marker; -1: of nobody
};

class Finder : public ::testing::Test {
 protected:
  std::vector<BodyModel> bodies(std::size_t count, std::size_t markers) {
    std::vector<BodyModel> models;
    for (std::size_t k = 0; k < count; ++k) models.push_back(random_body(random, markers, std::to_string(k)));
    return models;
  }
  static BodyFinder finder(const std::vector<BodyModel>& models) {
    std::vector<WantedShape> shapes;
    for (const BodyModel& model : models) shapes.push_back({model.markers_in_body, model.marker_sd_m});
    return BodyFinder(shapes);
  }
  void add(Crowd& crowd, const BodyModel& model, int body, const Pose& pose, double missing) {
    for (std::size_t m = 0; m < model.markers_in_body.size(); ++m)
      if (uniform(random, 0, 1) >= missing)
        add_point(crowd, pose * (model.markers_in_body[m] + normal3(random, model.marker_sd_m)), body,
                  static_cast<int>(m));
  }
  void add_point(Crowd& crowd, const Eigen::Vector3d& at, int body, int marker) {
    crowd.points.push_back({at + normal3(random, kSd_m), kSd_m * kSd_m * Eigen::Matrix3d::Identity()});
    crowd.origin.emplace_back(body, marker);
  }
  void add_clutter(Crowd& crowd, std::size_t count) {
    for (std::size_t k = 0; k < count; ++k)
      add_point(crowd, {uniform(random, -1.2, 1.2), uniform(random, -1.2, 1.2), uniform(random, 0.0, 1.6)},
                -1, -1);
  }

  static constexpr double kSd_m = 0.0003;
  std::mt19937_64 random{11};
  std::vector<FoundBody> found;
  FinderCounters counters;
};

TEST_F(Finder, EveryBodyInACrowd) {
  const auto models = bodies(20, 5);
  BodyFinder f = finder(models);
  const std::vector<std::uint32_t> wanted(models.size(), 1);
  int right = 0, wrong = 0, expected = 0;
  double seconds = 0.0;
  for (int run = 0; run < 20; ++run) {
    Crowd crowd;
    std::vector<Pose> poses;
    for (std::size_t k = 0; k < models.size(); ++k) {
      poses.push_back(random_pose(random));
      add(crowd, models[k], static_cast<int>(k), poses.back(), 0.1);
    }
    add_clutter(crowd, 200 - crowd.points.size());
    std::vector<int> seen(models.size(), 0);
    for (const auto& [body, marker] : crowd.origin)
      if (body >= 0) ++seen[static_cast<std::size_t>(body)];
    for (const int s : seen) expected += s >= 4 ? 1 : 0;
    const auto begin = std::chrono::steady_clock::now();
    f.find(crowd.points, wanted, found, counters);
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    for (const FoundBody& body : found) {
      int good = 0;
      for (std::size_t m = 0; m < 5; ++m)
        if (body.point_of_marker[m] != kMarkerNotSeen)
          good += crowd.origin[body.point_of_marker[m]] ==
                          std::pair(static_cast<int>(body.shape), static_cast<int>(m))
                      ? 1
                      : 0;
      const Vector6 error = pose_difference(body.world_from_shape, poses[body.shape]);
      const bool near = error.tail<3>().norm() < 0.005 && error.head<3>().norm() < 0.1;
      (near && good >= 3 ? right : wrong) += 1;
      if (seen[body.shape] == 5 && body.markers == 5) {
        EXPECT_EQ(good, 5);
      }
    }
  }
  std::printf(
      "20 bodies among 200 points: %.0f us, %d right of %d with 4 or more markers, %d wrong, %g candidates\n",
      seconds / 20 * 1e6, right, expected, wrong, static_cast<double>(counters.candidates) / 20);
  EXPECT_GE(right, expected);
  EXPECT_LE(wrong, 4);  // three points of nobody that fit by chance
  EXPECT_EQ(counters.candidates_cut, 0u);
}

TEST_F(Finder, HalfOfAnEightMarkerBodyIsNotEnough) {
  const auto models = bodies(1, 8);
  BodyFinder f = finder(models);
  const std::vector<std::uint32_t> wanted{1};
  Crowd crowd;
  add(crowd, models[0], 0, random_pose(random), 0.0);
  crowd.points.resize(5);
  f.find(crowd.points, wanted, found, counters);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].markers, 5u);
  crowd.points.resize(4);
  f.find(crowd.points, wanted, found, counters);
  EXPECT_TRUE(found.empty());
}

TEST_F(Finder, TheMirrorImageIsRefused) {
  for (const std::size_t markers : {4u, 5u, 6u}) {
    int taken = 0;
    for (int run = 0; run < 50; ++run) {
      const auto models = bodies(1, markers);
      BodyFinder f = finder(models);
      BodyModel mirrored = models[0];
      for (Eigen::Vector3d& p : mirrored.markers_in_body) p.x() = -p.x();
      Crowd crowd;
      add(crowd, mirrored, 0, random_pose(random), 0.0);
      const std::vector<std::uint32_t> wanted{1};
      f.find(crowd.points, wanted, found, counters);
      taken += static_cast<int>(found.size());
    }
    EXPECT_LE(taken, 2) << markers;  // nearly flat ones are their own mirror images
  }
  EXPECT_GT(counters.mirrored, 40u);
}

TEST_F(Finder, IdenticalBodiesAreAllFound) {
  const auto models = bodies(1, 5);
  BodyFinder f = finder(models);
  Crowd crowd;
  std::vector<Pose> poses;
  for (int k = 0; k < 4; ++k) {
    poses.push_back(random_pose(random));
    poses.back().translation.x() = -0.9 + 0.6 * k;
    add(crowd, models[0], k, poses.back(), 0.0);
  }
  add_clutter(crowd, 20);
  const std::vector<std::uint32_t> three{3};
  f.find(crowd.points, three, found, counters);
  EXPECT_EQ(found.size(), 3u);
  const std::vector<std::uint32_t> five{5};
  f.find(crowd.points, five, found, counters);
  ASSERT_EQ(found.size(), 4u);
  for (const FoundBody& body : found) {
    EXPECT_EQ(body.markers, 5u);
    EXPECT_GT(body.score, body.runner_up + 5.0);
  }
}

TEST_F(Finder, ASymmetricBodyHasARunnerUp) {
  const std::vector<BodyModel> models{
      {"square", {{0.05, 0.05, 0}, {-0.05, 0.05, 0}, {-0.05, -0.05, 0}, {0.05, -0.05, 0}}}};
  BodyFinder f = finder(models);
  Crowd crowd;
  add(crowd, models[0], 0, random_pose(random), 0.0);
  const std::vector<std::uint32_t> wanted{1};
  f.find(crowd.points, wanted, found, counters);
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].relabelled);
  EXPECT_LT(found[0].score - found[0].runner_up, 8.0);
}

TEST_F(Finder, CostIsNearLinear) {
  double per_point[2];
  for (const int k : {0, 1}) {
    const std::size_t count = k == 0 ? 10 : 40;
    const auto models = bodies(count, 5);
    BodyFinder f = finder(models);
    const std::vector<std::uint32_t> wanted(count, 1);
    double best = 1e9;
    for (int run = 0; run < 10; ++run) {
      Crowd crowd;
      // The same density in both rooms.
      for (std::size_t b = 0; b < count; ++b) {
        Pose pose = random_pose(random);
        pose.translation.x() += 2.0 * static_cast<double>(b / 10);
        add(crowd, models[b], static_cast<int>(b), pose, 0.0);
      }
      const auto begin = std::chrono::steady_clock::now();
      f.find(crowd.points, wanted, found, counters);
      best = std::min(best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
      EXPECT_GE(found.size(), count - 1);
    }
    per_point[k] = best / static_cast<double>(5 * count);
  }
  std::printf("%.2f us a point with 10 bodies, %.2f us with 40\n", 1e6 * per_point[0], 1e6 * per_point[1]);
  // Each pair of points is compared with every shape, so four times the bodies cost more a point, too.
  EXPECT_LT(per_point[1], 8.0 * per_point[0]);
}

}  // namespace
}  // namespace glint
