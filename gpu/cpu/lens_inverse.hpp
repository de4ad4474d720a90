// SPDX-License-Identifier: MIT
// undistort_blob() for many blobs of one camera: the same results, sooner.
#pragma once

#include <array>

#include "gpu/lens.hpp"

namespace glint::gpu {

/// Starts Newton's method close to the solution, by a polynomial fitted to the lens, where the lens model is
/// known to be one to one; elsewhere it is gpu::undistort_blob() itself. Differs from that by less than 1e-6
/// px.
class LensInverse {
 public:
  explicit LensInverse(const CameraFormat& format) noexcept;

  Undistorted undistort_blob(double x_px, double y_px, double var_xx_px2, double var_xy_px2,
                             double var_yy_px2) const noexcept;

 private:
  static constexpr std::size_t kNodes = 7;

  Lens lens_;
  double unfolded_;  // the model is one to one for x^2 + y^2 <= this
  // Newton's form of the polynomial that gives undistorted / distorted radius from the distorted radius
  // squared.
  std::array<double, kNodes> nodes_{}, factors_{};
};

}  // namespace glint::gpu
