// SPDX-License-Identifier: MIT
// The lens model in double precision: what the shaders compute in float, and the reference for it.
#pragma once

#include "gpu/detector.hpp"

namespace glint::gpu {

struct Undistorted {
  double x = 0.0, y = 0.0;  ///< z = 1 plane
  bool converged = false;   ///< false: the model folds over here
};

/// z = 1 plane -> distorted pixel.
void distort(const Lens& lens, double x, double y, double& x_px, double& y_px) noexcept;

/// Distorted pixel -> z = 1 plane, by damped Newton steps; converges wherever the model is monotonic
/// between the centre and the point.
Undistorted undistort(const Lens& lens, double x_px, double y_px) noexcept;

/// Mean of the undistorted pixels of a blob from its centroid and second central moments (pixels^2):
/// undistort(mean) + 1/2 tr(H cov), H the second derivative of the inverse model.
Undistorted undistort_blob(const Lens& lens, double x_px, double y_px, double var_xx_px2, double var_xy_px2,
                           double var_yy_px2) noexcept;

}  // namespace glint::gpu
