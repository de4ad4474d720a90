// SPDX-License-Identifier: MIT
// The assignment is the best there is, not the greedy one.
#include "host/sim/point_assignment.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

using Points = std::vector<Eigen::Vector3d>;

TEST(PointAssignment, NearestPairFirstWouldBeWorse) {
  // The nearest pair is sample 0 with marker 1, which leaves sample 1 alone.
  const Points markers{{0.0, 0, 0}, {1.0, 0, 0}}, samples{{0.55, 0, 0}, {1.5, 0, 0}};
  PointAssignment assignment;
  assignment.solve(samples, markers, 0.65);
  EXPECT_EQ(assignment.marker_of(0), 0);
  EXPECT_EQ(assignment.marker_of(1), 1);
  EXPECT_EQ(assignment.sample_of(1), 1);
  EXPECT_EQ(assignment.markers_near(0), 2u);
  EXPECT_EQ(assignment.markers_near(1), 1u);
}

TEST(PointAssignment, WhatIsFarOrNoNumberStaysAlone) {
  const Points markers{{0, 0, 0}},
      samples{{0.02, 0, 0}, Eigen::Vector3d::Constant(std::nan("")), {0, 0, 0.001}};
  PointAssignment assignment;
  assignment.solve(samples, markers, 0.01);
  EXPECT_EQ(assignment.marker_of(0), -1);
  EXPECT_EQ(assignment.marker_of(1), -1);
  EXPECT_EQ(assignment.marker_of(2), 0);
  assignment.solve({}, markers, 0.01);
  EXPECT_EQ(assignment.sample_of(0), -1);
}

double cost(const Points& samples, const Points& markers, const std::vector<int>& marker_of, double gate_m) {
  double sum = 0.0;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    sum += marker_of[s] < 0 ? gate_m * gate_m
                            : (samples[s] - markers[static_cast<std::size_t>(marker_of[s])]).squaredNorm();
  }
  return sum;
}

double best_cost(const Points& samples, const Points& markers, double gate_m, std::vector<int>& chosen) {
  if (chosen.size() == samples.size()) return cost(samples, markers, chosen, gate_m);
  const std::size_t s = chosen.size();
  double best = 1e300;
  for (int m = -1; m < static_cast<int>(markers.size()); ++m) {
    const bool taken = m >= 0 && std::find(chosen.begin(), chosen.end(), m) != chosen.end();
    if (taken || (m >= 0 && (samples[s] - markers[static_cast<std::size_t>(m)]).norm() >= gate_m)) continue;
    chosen.push_back(m);
    best = std::min(best, best_cost(samples, markers, gate_m, chosen));
    chosen.pop_back();
  }
  return best;
}

TEST(PointAssignment, AsGoodAsTryingEverything) {
  Random random(3);
  PointAssignment assignment;
  for (int round = 0; round < 3000; ++round) {
    const auto draw = [&](std::size_t most) {
      Points points(1 + static_cast<std::size_t>(random.uniform() * static_cast<double>(most)));
      for (Eigen::Vector3d& point : points)
        point = {random.uniform(0, 2.5), random.uniform(0, 2.5), random.uniform(0, 0.5)};
      return points;
    };
    const Points samples = draw(5), markers = draw(5);
    assignment.solve(samples, markers, 1.0);
    std::vector<int> found, chosen;
    for (std::size_t s = 0; s < samples.size(); ++s) {
      found.push_back(assignment.marker_of(s));
      if (found.back() < 0) continue;
      ASSERT_EQ(assignment.sample_of(static_cast<std::size_t>(found.back())), static_cast<int>(s));
    }
    ASSERT_NEAR(cost(samples, markers, found, 1.0), best_cost(samples, markers, 1.0, chosen), 1e-12);
  }
}

}  // namespace
}  // namespace glint::sim
