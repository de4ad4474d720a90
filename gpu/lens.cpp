// SPDX-License-Identifier: MIT
// OpenCV's radial-tangential model (Brown 1966) forwards, backwards, and with its second derivatives.
#include "gpu/lens.hpp"

#include <algorithm>
#include <cmath>

#include "gpu/lens_model.hpp"

namespace glint::gpu {
namespace {

/// Is the Jacobian positive definite at `samples` points from behind (x0, y0) to (x1, y1)?
bool unfolded_between(const Lens& lens, double x0, double y0, double x1, double y1, int samples) noexcept {
  for (int i = 1; i <= samples; ++i) {
    const double t = static_cast<double>(i) / samples;
    if (!forward(lens, x0 + t * (x1 - x0), y0 + t * (y1 - y0)).positive_definite()) return false;
  }
  return true;
}

/// Is the Jacobian positive definite everywhere between the centre and (x, y)? Then the model is one to
/// one on that line and the point lies on the branch that a real lens uses.
bool unfolded_up_to(const Lens& lens, double x, double y) noexcept {
  if (surely_unfolded(lens, x * x + y * y)) return true;
  // The bound is not sharp: look.
  return unfolded_between(lens, 0.0, 0.0, x, y, 64);
}

struct NewtonResult {
  double x, y;
  bool converged;
};

/// Newton steps to forward(x, y) = (x_d, y_d), halved while they leave the unfolded region or do not
/// lower the residual.
NewtonResult newton(const Lens& lens, double x_d, double y_d, double x, double y) noexcept {
  constexpr int kIterations = 30;
  constexpr double kTolerance = 1e-14;
  Forward f = forward(lens, x, y);
  double rx = x_d - f.x, ry = y_d - f.y, error = rx * rx + ry * ry;  // squared, like the tolerance
  const double tolerance = kTolerance * kTolerance * (1.0 + x_d * x_d + y_d * y_d);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    if (!f.positive_definite()) return {x, y, false};
    if (error <= tolerance) return {x, y, true};
    const double det = f.determinant();
    const double dx = (f.yy * rx - f.xy * ry) / det, dy = (f.xx * ry - f.xy * rx) / det;
    bool better = false;
    for (double step = 1.0; step > 1e-4; step *= 0.5) {
      const Forward trial = forward(lens, x + step * dx, y + step * dy);
      const double trial_rx = x_d - trial.x, trial_ry = y_d - trial.y;
      const double trial_error = trial_rx * trial_rx + trial_ry * trial_ry;
      if (trial.positive_definite() && trial_error < error) {
        x += step * dx, y += step * dy;
        f = trial, rx = trial_rx, ry = trial_ry, error = trial_error;
        better = true;
        break;
      }
    }
    // No step helps any more: either rounding is all that is left, or this is the fold.
    if (!better) return {x, y, error <= 1e4 * tolerance};
  }
  return {x, y, error <= 1e4 * tolerance};
}

/// Follows the solution from the centre outwards, so that it cannot land on another branch; stops where
/// the model folds.
Undistorted follow_from_centre(const Lens& lens, double x_d, double y_d) noexcept {
  double x = 0.0, y = 0.0, reached = 0.0;
  constexpr double kFirstStep = 1.0 / 16.0, kLastStep = 1.0 / 65536.0;
  for (double step = kFirstStep; reached < 1.0;) {
    const double t = std::min(1.0, reached + step);
    const NewtonResult next = newton(lens, t * x_d, t * y_d, x, y);
    // Close to a fold a Newton step may leap over it.
    if (next.converged && unfolded_between(lens, x, y, next.x, next.y, 8)) {
      x = next.x, y = next.y, reached = t;
    } else {
      step *= 0.5;
      if (step < kLastStep) return {x, y, false};
    }
  }
  return {x, y, unfolded_up_to(lens, x, y)};
}

}  // namespace

void distort(const Lens& lens, double x, double y, double& x_px, double& y_px) noexcept {
  const Forward f = forward(lens, x, y);
  x_px = lens.fx_px * f.x + lens.cx_px;
  y_px = lens.fy_px * f.y + lens.cy_px;
}

Undistorted undistort(const Lens& lens, double x_px, double y_px) noexcept {
  const double x_d = (x_px - lens.cx_px) / lens.fx_px, y_d = (y_px - lens.cy_px) / lens.fy_px;
  if (!std::isfinite(x_d) || !std::isfinite(y_d)) return {0.0, 0.0, false};
  const NewtonResult direct = newton(lens, x_d, y_d, x_d, y_d);
  if (direct.converged && unfolded_up_to(lens, direct.x, direct.y)) return {direct.x, direct.y, true};
  return follow_from_centre(lens, x_d, y_d);
}

Undistorted undistort_blob(const Lens& lens, double x_px, double y_px, double var_xx_px2, double var_xy_px2,
                           double var_yy_px2) noexcept {
  const Undistorted u = undistort(lens, x_px, y_px);
  if (!u.converged) return u;
  return mean_undistorted(lens, forward(lens, u.x, u.y), u, var_xx_px2, var_xy_px2, var_yy_px2);
}

}  // namespace glint::gpu
