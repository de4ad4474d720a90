// SPDX-License-Identifier: MIT
// How well the markers could be located at best: the Cramer-Rao bound of the rendered images.
#pragma once

#include <span>

#include <Eigen/Core>

#include "host/sim/backdrop.hpp"
#include "host/sim/marker_painter.hpp"
#include "host/sim/scene.hpp"

namespace glint {

/// Fisher information of a marker's image position in each camera comes from the noiseless profile and the
/// noise of each of its pixels (shot of marker and stray light, read, requested, 1/12 of rounding; clipped
/// pixels tell nothing); brightness, size and shape are taken as known. The bound for the 3D position is
/// trace((sum J' I J)^-1) over the cameras in which the marker is clean. (Kay, Fundamentals of Statistical
/// Signal Processing I, 1993, ch. 3.) Thread-bound.
class PositionBound {
 public:
  /// `scene` must outlive it.
  explicit PositionBound(const Scene& scene);

  /// Of image position, in px^-2. Zero if the marker is not in that image.
  Eigen::Matrix2d information_px(const TickTruth& truth, std::uint32_t camera, std::uint32_t marker);
  /// Lowest mean squared 3D error in m^2 that an unbiased method can have; infinity if fewer than two cameras
  /// see the marker clean.
  double variance_m2(const TickTruth& truth, std::uint32_t marker);

 private:
  const Scene& scene_;
  sim::NoiseModel noise_;
  sim::MarkerPainter painter_;
};

}  // namespace glint
