// SPDX-License-Identifier: MIT
// A polynomial through points of the radial model, then Newton steps on the whole model.
#include "gpu/cpu/lens_inverse.hpp"

#include <cmath>
#include <numbers>

#include "gpu/lens_model.hpp"

namespace glint::gpu {
namespace {

/// The largest t in [0, most] for which `holds`, if it holds up to some t and not beyond.
template <typename Holds>
double last_that(double most, Holds holds) noexcept {
  if (holds(most)) return most;
  double low = 0.0, high = most;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return low;
}

}  // namespace

LensInverse::LensInverse(const CameraFormat& format) noexcept : lens_(format.lens) {
  constexpr double kWidest = 100.0;  // tan of 89.4 degrees, squared it is beyond any pinhole
  unfolded_ = last_that(kWidest * kWidest, [&](double s) { return surely_unfolded(lens_, s); });
  const auto farthest = [](double centre, double size) {
    return std::max(std::abs(centre), std::abs(size - centre));
  };
  const double corner = std::hypot(farthest(lens_.cx_px, format.width_px) / lens_.fx_px,
                                   farthest(lens_.cy_px, format.height_px) / lens_.fy_px);
  const auto [k1, k2, p1, p2, k3] = lens_.k1_k2_p1_p2_k3;
  const auto radial = [&](double s) { return 1.0 + s * (k1 + s * (k2 + s * k3)); };
  const double reach = last_that(std::sqrt(unfolded_), [&](double r) { return r * radial(r * r) <= corner; });
  for (std::size_t i = 0; i < kNodes; ++i) {
    // Chebyshev nodes of the undistorted radius: there the polynomial is as good as it can be.
    const double angle = std::numbers::pi * (static_cast<double>(i) + 0.5) / kNodes;
    const double r = 0.5 * reach * (1.0 + std::cos(angle)), factor = radial(r * r);
    nodes_[i] = r * factor * r * factor;
    factors_[i] = 1.0 / factor;
  }
  for (std::size_t order = 1; order < kNodes; ++order) {
    for (std::size_t i = kNodes - 1; i >= order; --i)
      factors_[i] = (factors_[i] - factors_[i - 1]) / (nodes_[i] - nodes_[i - order]);
  }
}

Undistorted LensInverse::undistort_blob(double x_px, double y_px, double var_xx_px2, double var_xy_px2,
                                        double var_yy_px2) const noexcept {
  constexpr int kSteps = 5;
  constexpr double kLeastDeterminant = 0.25;
  constexpr double kSmall = 1e-18;  // a step squared: behind it, `f` and the solution are as good as exact
  const double x_d = (x_px - lens_.cx_px) / lens_.fx_px, y_d = (y_px - lens_.cy_px) / lens_.fy_px;
  const double s = x_d * x_d + y_d * y_d;
  double ratio = factors_[kNodes - 1];
  for (std::size_t i = kNodes - 1; i-- > 0;) ratio = ratio * (s - nodes_[i]) + factors_[i];
  double x = x_d * ratio, y = y_d * ratio;
  // Less what the tangential part adds there.
  const double p1 = lens_.k1_k2_p1_p2_k3[2], p2 = lens_.k1_k2_p1_p2_k3[3];
  const double t_x = 2.0 * p1 * x * y + p2 * (3.0 * x * x + y * y);
  const double t_y = p1 * (x * x + 3.0 * y * y) + 2.0 * p2 * x * y;
  x -= t_x * ratio, y -= t_y * ratio;
  for (int step = 0; step < kSteps; ++step) {
    const Forward f = forward(lens_, x, y);
    const double rx = x_d - f.x, ry = y_d - f.y, over_det = 1.0 / f.determinant();
    const double dx = (f.yy * rx - f.xy * ry) * over_det, dy = (f.xx * ry - f.xy * rx) * over_det;
    x += dx, y += dy;
    if (!(dx * dx + dy * dy <= kSmall)) continue;
    // Within the disc where the model is one to one this is the solution; nothing is known of others. Close
    // to a fold rounding errors grow.
    if (!(x * x + y * y <= unfolded_ && f.determinant() >= kLeastDeterminant)) break;
    return mean_undistorted(lens_, f, {x, y, true}, var_xx_px2, var_xy_px2, var_yy_px2);
  }
  return gpu::undistort_blob(lens_, x_px, y_px, var_xx_px2, var_xy_px2, var_yy_px2);
}

}  // namespace glint::gpu
