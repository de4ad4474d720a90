// SPDX-License-Identifier: MIT
// Least squares over one camera's lens and the poses of a board.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/calibrate/board_session.hpp"
#include "host/calibrate/sighting_model.hpp"

namespace glint {

/// One view as the solver moves it.
struct SolverView {
  const BoardPoints* seen = nullptr;  ///< borrowed
  Pose camera_from_board;
  bool used = true;  ///< else it is left alone
};

struct LensSolution {
  Intrinsics intrinsics{};
  double rms_px = 0.0;    ///< per corner, of the views used
  double sigma_px = 0.0;  ///< per axis, degrees of freedom counted
  bool converged = false;
};

/// What may move beside focal lengths, principal point, k1 and k2.
struct LensFreedom {
  bool tangential = true, k3 = false;
};

/// Moves `intrinsics` and the poses of the views in use. Huber's loss beyond `huber_px`.
LensSolution solve_lens(std::span<const Eigen::Vector3d> board, std::span<SolverView> views,
                        const Intrinsics& start, LensFreedom freedom, double huber_px);

/// Standard deviations at a solution, if a corner's is `sigma_px`; nothing if the views do not determine all
/// parameters. Those that do not move have 0.
std::optional<Intrinsics> lens_deviations(std::span<const Eigen::Vector3d> board,
                                          std::span<const SolverView> views, const LensSolution& at,
                                          LensFreedom freedom, double huber_px);

/// Measured minus predicted, corner by corner.
std::vector<Eigen::Vector2d> residuals_px(std::span<const Eigen::Vector3d> board, const SolverView& view,
                                          const Intrinsics& intrinsics);

}  // namespace glint
