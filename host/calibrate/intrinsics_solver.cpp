// SPDX-License-Identifier: MIT
// The problem for Ceres: one block of intrinsics, one pose a view.
#include "host/calibrate/intrinsics_solver.hpp"

#include <cmath>

#include <ceres/ceres.h>

namespace glint {
namespace {

struct CornerError {
  Eigen::Vector3d point;
  Eigen::Vector2d pixel;

  template <typename T>
  bool operator()(const T* intrinsics, const T* pose, T* residual) const {
    if (!project(intrinsics, pose, point, residual)) return false;
    residual[0] -= pixel.x();
    residual[1] -= pixel.y();
    return true;
  }
};

void build(ceres::Problem& problem, std::span<const Eigen::Vector3d> board, std::span<SolverView> views,
           IntrinsicsBlock& intrinsics, LensFreedom freedom, double huber_px) {
  problem.AddParameterBlock(intrinsics.data(), 9);
  std::vector<int> fixed;
  for (const int n : {6, 7, 8})
    if (n == 8 ? !freedom.k3 : !freedom.tangential) fixed.push_back(n);
  if (!fixed.empty()) problem.SetManifold(intrinsics.data(), new ceres::SubsetManifold(9, fixed));
  for (SolverView& view : views) {
    if (!view.used) continue;
    for (std::size_t i = 0; i < view.seen->points.size(); ++i) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<CornerError, 2, 9, 6>(
                                   new CornerError{board[view.seen->points[i]], view.seen->pixels[i]}),
                               new ceres::HuberLoss(huber_px), intrinsics.data(), view.pose.data());
    }
  }
}

}  // namespace

LensSolution solve_lens(std::span<const Eigen::Vector3d> board, std::span<SolverView> views,
                        const IntrinsicsBlock& start, LensFreedom freedom, double huber_px) {
  LensSolution solution;
  solution.intrinsics = start;
  ceres::Problem problem;
  build(problem, board, views, solution.intrinsics, freedom, huber_px);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_SCHUR;  // without the poses nine unknowns are left
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-10;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  solution.converged = summary.IsSolutionUsable();

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

std::optional<IntrinsicsBlock> lens_deviations(std::span<const Eigen::Vector3d> board,
                                               std::span<SolverView> views, const LensSolution& at,
                                               LensFreedom freedom, double huber_px) {
  ceres::Problem problem;
  IntrinsicsBlock intrinsics = at.intrinsics;
  build(problem, board, views, intrinsics, freedom, huber_px);
  ceres::Covariance::Options options;
  ceres::Covariance covariance(options);
  const std::vector<std::pair<const double*, const double*>> wanted{{intrinsics.data(), intrinsics.data()}};
  if (!covariance.Compute(wanted, &problem)) return std::nullopt;
  Eigen::Matrix<double, 9, 9, Eigen::RowMajor> block;
  if (!covariance.GetCovarianceBlock(intrinsics.data(), intrinsics.data(), block.data())) return std::nullopt;
  IntrinsicsBlock deviations{};
  for (std::size_t i = 0; i < 9; ++i) {
    const auto n = static_cast<Eigen::Index>(i);
    deviations[i] = at.sigma_px * std::sqrt(std::max(0.0, block(n, n)));
  }
  return deviations;
}

std::vector<Eigen::Vector2d> residuals_px(std::span<const Eigen::Vector3d> board, const SolverView& view,
                                          const IntrinsicsBlock& intrinsics) {
  std::vector<Eigen::Vector2d> residuals;
  for (std::size_t i = 0; i < view.seen->points.size(); ++i) {
    Eigen::Vector2d predicted;
    // A corner behind the camera is as wrong as can be.
    const bool ahead =
        project(intrinsics.data(), view.pose.data(), board[view.seen->points[i]], predicted.data());
    residuals.push_back(ahead ? Eigen::Vector2d(view.seen->pixels[i] - predicted)
                              : Eigen::Vector2d(1e4, 1e4));
  }
  return residuals;
}

}  // namespace glint
