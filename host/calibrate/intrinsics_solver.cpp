// SPDX-License-Identifier: MIT
// The problem for Ceres: one block of intrinsics, one pose a view.
#include "host/calibrate/intrinsics_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <ceres/ceres.h>

#include "host/calibrate/reprojection_cost.hpp"

namespace glint {
namespace {

/// The parameters as Ceres moves them, and what they are to explain.
class LensProblem {
 public:
  LensProblem(std::span<const Eigen::Vector3d> board, std::span<const SolverView> views,
              const Intrinsics& start, LensFreedom freedom, double huber_px)
      : intrinsics_(start) {
    problem_.AddParameterBlock(intrinsics_.data(), 9);
    std::vector<int> fixed;
    for (const int n : {6, 7, 8})
      if (n == 8 ? !freedom.k3 : !freedom.tangential) fixed.push_back(n);
    if (!fixed.empty()) problem_.SetManifold(intrinsics_.data(), new ceres::SubsetManifold(9, fixed));
    poses_.reserve(views.size());  // Ceres keeps their addresses
    for (const SolverView& view : views) {
      double* pose = poses_.emplace_back(pose_block(view.camera_from_board)).data();
      if (!view.used) continue;
      problem_.AddParameterBlock(pose, 7, new PoseManifold);
      for (std::size_t i = 0; i < view.seen->points.size(); ++i)
        problem_.AddResidualBlock(new ViewCost(view.seen->pixels[i], board[view.seen->points[i]]),
                                  new ceres::HuberLoss(huber_px), pose, intrinsics_.data());
    }
  }

  ceres::Problem& ceres() noexcept { return problem_; }
  const Intrinsics& intrinsics() const noexcept { return intrinsics_; }
  Pose camera_from_board(std::size_t view) const { return pose_of(poses_[view].data()); }

 private:
  Intrinsics intrinsics_;
  std::vector<PoseBlock> poses_;
  ceres::Problem problem_;
};

}  // namespace

LensSolution solve_lens(std::span<const Eigen::Vector3d> board, std::span<SolverView> views,
                        const Intrinsics& start, LensFreedom freedom, double huber_px) {
  LensProblem problem(board, views, start, freedom, huber_px);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;  // without the poses nine unknowns are left
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem.ceres(), &summary);
  LensSolution solution;
  solution.intrinsics = problem.intrinsics();
  solution.converged = summary.IsSolutionUsable();
  for (std::size_t v = 0; v < views.size(); ++v)
    if (views[v].used) views[v].camera_from_board = problem.camera_from_board(v);

  double squares = 0.0;
  std::size_t corners = 0, unknowns = 6 + (freedom.tangential ? 2u : 0u) + (freedom.k3 ? 1u : 0u);
  for (const SolverView& view : views) {
    if (!view.used) continue;
    unknowns += 6;
    for (const Eigen::Vector2d& r : residuals_px(board, view, solution.intrinsics))
      squares += r.squaredNorm();
    corners += view.seen->points.size();
  }
  if (corners > 0) solution.rms_px = std::sqrt(squares / static_cast<double>(corners));
  if (2 * corners > unknowns)
    solution.sigma_px = std::sqrt(squares / static_cast<double>(2 * corners - unknowns));
  return solution;
}

std::optional<Intrinsics> lens_deviations(std::span<const Eigen::Vector3d> board,
                                          std::span<const SolverView> views, const LensSolution& at,
                                          LensFreedom freedom, double huber_px) {
  LensProblem problem(board, views, at.intrinsics, freedom, huber_px);
  ceres::Covariance covariance({});
  const double* lens = problem.intrinsics().data();
  const std::vector<std::pair<const double*, const double*>> wanted{{lens, lens}};
  if (!covariance.Compute(wanted, &problem.ceres())) return std::nullopt;
  Eigen::Matrix<double, 9, 9, Eigen::RowMajor> block;
  if (!covariance.GetCovarianceBlock(lens, lens, block.data())) return std::nullopt;
  Intrinsics deviations{};
  for (std::size_t i = 0; i < 9; ++i) {
    const auto n = static_cast<Eigen::Index>(i);
    deviations[i] = at.sigma_px * std::sqrt(std::max(0.0, block(n, n)));
  }
  return deviations;
}

std::vector<Eigen::Vector2d> residuals_px(std::span<const Eigen::Vector3d> board, const SolverView& view,
                                          const Intrinsics& intrinsics) {
  std::vector<Eigen::Vector2d> residuals;
  for (std::size_t i = 0; i < view.seen->points.size(); ++i) {
    PredictedSighting predicted;
    const Eigen::Vector3d in_camera = view.camera_from_board * board[view.seen->points[i]];
    // A corner behind the camera is as wrong as can be.
    residuals.push_back(predict_sighting(intrinsics.data(), in_camera, 0.0, predicted)
                            ? Eigen::Vector2d(view.seen->pixels[i] - predicted.pixel)
                            : Eigen::Vector2d(1e4, 1e4));
  }
  return residuals;
}

}  // namespace glint
