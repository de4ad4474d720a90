// SPDX-License-Identifier: MIT
// Residuals for Ceres with analytic derivatives; private to host/calibrate.
#pragma once

#include <array>

#include <ceres/ceres.h>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "host/calibrate/sighting_model.hpp"

namespace glint {

/// d(q p)/dq for a unit quaternion in Eigen's order x y z w: from q p = p + 2w (u x p) + 2 u x (u x p).
Eigen::Matrix<double, 3, 4> rotated_by_quaternion(const Eigen::Quaterniond& q, const Eigen::Vector3d& p);

/// A pose in one block: rotation in Eigen's order x y z w, then translation.
using PoseBlock = std::array<double, 7>;
/// How such a block moves.
using PoseManifold = ceres::ProductManifold<ceres::EigenQuaternionManifold, ceres::EuclideanManifold<3>>;

PoseBlock pose_block(const Pose& pose);
Pose pose_of(const double* block);

struct SightingTerms {
  Eigen::Vector2d pixel;
  double sigma_px, marker_radius_m;
};

/// Predicted minus measured, over sigma. Blocks: camera_from_world rotation (4) and translation (3),
/// intrinsics (9), then the target: the points of a marker or wand (3 times their number, `kTarget` in all)
/// of which this is number `point`.
template <int kTarget>
class PointCost final : public ceres::SizedCostFunction<2, 4, 3, 9, kTarget> {
 public:
  PointCost(const SightingTerms& terms, int point) : terms_(terms), point_(point) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  SightingTerms terms_;
  int point_;
};

/// The same for a board: its block is world_from_target (PoseBlock).
class BoardCost final : public ceres::SizedCostFunction<2, 4, 3, 9, 7> {
 public:
  BoardCost(const SightingTerms& terms, const Eigen::Vector3d& point_in_target)
      : terms_(terms), point_in_target_(point_in_target) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  SightingTerms terms_;
  Eigen::Vector3d point_in_target_;
};

/// Predicted minus measured in pixels for one camera alone. Blocks: camera_from_target (PoseBlock),
/// intrinsics (9).
class ViewCost final : public ceres::SizedCostFunction<2, 7, 9> {
 public:
  ViewCost(const Eigen::Vector2d& pixel, const Eigen::Vector3d& point_in_target)
      : pixel_(pixel), point_in_target_(point_in_target) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  Eigen::Vector2d pixel_;
  Eigen::Vector3d point_in_target_;
};

/// (distance of two points of the block - length) / sd.
template <int kTarget>
class LengthCost final : public ceres::SizedCostFunction<1, kTarget> {
 public:
  LengthCost(int a, int b, double length_m, double sd_m) : a_(a), b_(b), length_m_(length_m), sd_m_(sd_m) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  int a_, b_;
  double length_m_, sd_m_;
};

/// (value - expected) / sd for each of the nine; an sd of 0 gives no residual.
class IntrinsicsPrior final : public ceres::SizedCostFunction<9, 9> {
 public:
  IntrinsicsPrior(const Intrinsics& expected, const Intrinsics& sd) : expected_(expected), sd_(sd) {}
  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override;

 private:
  Intrinsics expected_, sd_;
};

}  // namespace glint
