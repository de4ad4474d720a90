// SPDX-License-Identifier: MIT
// OpenCV's radial-tangential model (Brown 1966) forwards, backwards, and with its second derivatives.
#include "gpu/lens.hpp"

#include <algorithm>
#include <cmath>

namespace glint::gpu {
namespace {

/// Distortion on the z = 1 plane with its derivatives. The Jacobian is symmetric, because the model is
/// the gradient of a scalar function; so are the two Hessians.
struct Forward {
  double x, y;        // distorted, z = 1 plane
  double xx, xy, yy;  // Jacobian: d x_d/dx, d x_d/dy = d y_d/dx, d y_d/dy

  double determinant() const noexcept { return xx * yy - xy * xy; }
  /// A symmetric matrix whose eigenvalues stay positive on the way from the centre has not folded.
  bool positive_definite() const noexcept { return xx > 0.0 && determinant() > 0.0; }
};

Forward forward(const Lens& lens, double x, double y) noexcept {
  const auto [k1, k2, p1, p2, k3] = lens.k1_k2_p1_p2_k3;
  const double s = x * x + y * y;
  const double g = 1.0 + s * (k1 + s * (k2 + s * k3));   // radial factor
  const double g1 = k1 + s * (2.0 * k2 + s * 3.0 * k3);  // dg/ds
  Forward f;
  f.x = x * g + 2.0 * p1 * x * y + p2 * (s + 2.0 * x * x);
  f.y = y * g + p1 * (s + 2.0 * y * y) + 2.0 * p2 * x * y;
  f.xx = g + 2.0 * x * x * g1 + 2.0 * p1 * y + 6.0 * p2 * x;
  f.xy = 2.0 * x * y * g1 + 2.0 * p1 * x + 2.0 * p2 * y;
  f.yy = g + 2.0 * y * y * g1 + 6.0 * p1 * y + 2.0 * p2 * x;
  return f;
}

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
  const auto [k1, k2, p1, p2, k3] = lens.k1_k2_p1_p2_k3;
  const double s = x * x + y * y, r = std::sqrt(s);
  // Bernstein coefficients on [0, s] bound a cubic from below: the radial slope 1 + 3 k1 s + 5 k2 s^2 +
  // 7 k3 s^3 and the radial factor itself. The tangential part cannot lower an eigenvalue by more than
  // the norm of its Jacobian, which is below 8 r (|p1| + |p2|).
  const auto lower_bound = [s](double a1, double a2, double a3) {
    const double c1 = a1 * s, c2 = a2 * s * s, c3 = a3 * s * s * s;
    return std::min({1.0, 1.0 + c1 / 3.0, 1.0 + (2.0 * c1 + c2) / 3.0, 1.0 + c1 + c2 + c3});
  };
  const double needed = 8.0 * r * (std::abs(p1) + std::abs(p2));
  if (std::min(lower_bound(k1, k2, k3), lower_bound(3.0 * k1, 5.0 * k2, 7.0 * k3)) > needed) return true;
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
  Undistorted u = undistort(lens, x_px, y_px);
  if (!u.converged) return u;
  // With D the forward model and u(p) its inverse, differentiating D(u(p)) = p twice gives
  // mean u(p) = u(mean p) - 1/2 J^-1 v, v_m = tr(H_m S), S = J^-1 cov J^-T: the delta method.
  const auto [k1, k2, p1, p2, k3] = lens.k1_k2_p1_p2_k3;
  const double x = u.x, y = u.y, s = x * x + y * y;
  const Forward f = forward(lens, x, y);
  const double det = f.determinant();
  const double ixx = f.yy / det, ixy = -f.xy / det, iyy = f.xx / det;  // J^-1, symmetric
  // Covariance on the distorted z = 1 plane, then on the undistorted one.
  const double cxx = var_xx_px2 / (lens.fx_px * lens.fx_px), cxy = var_xy_px2 / (lens.fx_px * lens.fy_px),
               cyy = var_yy_px2 / (lens.fy_px * lens.fy_px);
  const double axx = ixx * cxx + ixy * cxy, axy = ixx * cxy + ixy * cyy;
  const double ayx = ixy * cxx + iyy * cxy, ayy = ixy * cxy + iyy * cyy;
  const double sxx = axx * ixx + axy * ixy, sxy = axx * ixy + axy * iyy, syy = ayx * ixy + ayy * iyy;
  // Third derivatives of the scalar function whose gradient the model is: H_x = (txxx, txxy, txyy),
  // H_y = (txxy, txyy, tyyy).
  const double g1 = k1 + s * (2.0 * k2 + s * 3.0 * k3), g2 = 2.0 * k2 + 6.0 * k3 * s;
  const double txxx = 6.0 * x * g1 + 4.0 * x * x * x * g2 + 6.0 * p2;
  const double txxy = 2.0 * y * g1 + 4.0 * x * x * y * g2 + 2.0 * p1;
  const double txyy = 2.0 * x * g1 + 4.0 * x * y * y * g2 + 2.0 * p2;
  const double tyyy = 6.0 * y * g1 + 4.0 * y * y * y * g2 + 6.0 * p1;
  const double vx = txxx * sxx + 2.0 * txxy * sxy + txyy * syy;
  const double vy = txxy * sxx + 2.0 * txyy * sxy + tyyy * syy;
  u.x -= 0.5 * (ixx * vx + ixy * vy);
  u.y -= 0.5 * (ixy * vx + iyy * vy);
  return u;
}

}  // namespace glint::gpu
