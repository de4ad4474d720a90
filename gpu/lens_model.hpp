// SPDX-License-Identifier: MIT
// OpenCV's radial-tangential model (Brown 1966) with its derivatives: what every way of inverting it starts
// from.
#pragma once

#include <algorithm>
#include <cmath>

#include "gpu/lens.hpp"

namespace glint::gpu {

/// Distortion on the z = 1 plane with its derivatives. The Jacobian is symmetric, because the model is
/// the gradient of a scalar function; so are the two Hessians.
struct Forward {
  double x, y;        // distorted, z = 1 plane
  double xx, xy, yy;  // Jacobian: d x_d/dx, d x_d/dy = d y_d/dx, d y_d/dy

  double determinant() const noexcept { return xx * yy - xy * xy; }
  /// A symmetric matrix whose eigenvalues stay positive on the way from the centre has not folded.
  bool positive_definite() const noexcept { return xx > 0.0 && determinant() > 0.0; }
};

inline Forward forward(const Lens& lens, double x, double y) noexcept {
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

/// Is the Jacobian surely positive definite everywhere within the radius sqrt(s) on the z = 1 plane? Then the
/// model is one to one there. True for all smaller s, if it is for one.
inline bool surely_unfolded(const Lens& lens, double s) noexcept {
  const auto [k1, k2, p1, p2, k3] = lens.k1_k2_p1_p2_k3;
  // Bernstein coefficients on [0, s] bound a cubic from below: the radial slope 1 + 3 k1 s + 5 k2 s^2 +
  // 7 k3 s^3 and the radial factor itself. The tangential part cannot lower an eigenvalue by more than
  // the norm of its Jacobian, which is below 8 r (|p1| + |p2|).
  const auto lower_bound = [s](double a1, double a2, double a3) {
    const double c1 = a1 * s, c2 = a2 * s * s, c3 = a3 * s * s * s;
    return std::min({1.0, 1.0 + c1 / 3.0, 1.0 + (2.0 * c1 + c2) / 3.0, 1.0 + c1 + c2 + c3});
  };
  const double needed = 8.0 * std::sqrt(s) * (std::abs(p1) + std::abs(p2));
  return std::min(lower_bound(k1, k2, k3), lower_bound(3.0 * k1, 5.0 * k2, 7.0 * k3)) > needed;
}

/// Mean of the undistorted pixels of a blob, from the undistorted centroid `u` with the model's derivatives
/// `f` there, and the second central moments in pixels^2.
inline Undistorted mean_undistorted(const Lens& lens, const Forward& f, Undistorted u, double var_xx_px2,
                                    double var_xy_px2, double var_yy_px2) noexcept {
  // With D the forward model and u(p) its inverse, differentiating D(u(p)) = p twice gives
  // mean u(p) = u(mean p) - 1/2 J^-1 v, v_m = tr(H_m S), S = J^-1 cov J^-T: the delta method.
  const auto [k1, k2, p1, p2, k3] = lens.k1_k2_p1_p2_k3;
  const double x = u.x, y = u.y, s = x * x + y * y;
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
