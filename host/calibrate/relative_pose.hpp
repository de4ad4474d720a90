// SPDX-License-Identifier: MIT
// How two cameras stand to each other, from points that both saw.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/pose.hpp"

namespace glint {

/// What two cameras saw at one tick: the same points of the target, z = 1 plane.
struct PairTick {
  std::uint64_t tick = 0;
  std::vector<std::uint32_t> points;
  std::vector<Eigen::Vector2d> a, b;  ///< one for each of `points`
};

struct RelativePoseOptions {
  double tolerance = 0.003;  ///< of a ray from its epipolar plane, z = 1 plane: about 3 px of a usual lens
  bool ends_alike = false;   ///< which of the two points is which cannot be told: try both
  std::uint32_t most_trials = 2000;
};

struct RelativePose {
  Pose b_from_a;                      ///< translation of length 1
  std::vector<std::uint8_t> swapped;  ///< per tick: with ends_alike, b's two points are the other way round
  std::uint64_t inliers = 0;          ///< points within tolerance, in front of both cameras
  std::uint64_t points = 0;           ///< all
  double median_angle_rad = 0.0;      ///< between the two rays of an inlier
  double planar_share = 0.0;  ///< of the inliers that one homography explains as well: near 1, all lie in one
                              ///< plane, and the pose cannot be trusted
};

/// Essential matrix by the normalised eight-point method within MSAC, then least squares over its inliers; of
/// the four poses it allows, the one with the points in front (Hartley and Zisserman, Multiple View
/// Geometry, 11.2, 9.6.2; Torr and Zisserman, MLESAC, 2000). Deterministic. Nothing if there are fewer than
/// 16 points or no pose has half of them as inliers.
std::optional<RelativePose> relative_pose(const std::vector<PairTick>& ticks,
                                          const RelativePoseOptions& options);

/// Middle of the shortest line between two rays, in the frame of a; nothing behind a camera or without
/// parallax.
std::optional<Eigen::Vector3d> meeting_point(const Pose& b_from_a, const Eigen::Vector2d& a,
                                             const Eigen::Vector2d& b);

}  // namespace glint
