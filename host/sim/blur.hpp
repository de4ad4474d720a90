// SPDX-License-Identifier: MIT
// Filled shapes through optical blur and the pixel's square aperture, exact below the pixel.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/sim/sim_camera.hpp"

namespace glint::sim {

/// One-dimensional response of a row of pixels to a point and to an edge: Gaussian blur, then a box of one
/// pixel. Tabulated at 1/128 px and interpolated.
class BlurKernel {
 public:
  explicit BlurKernel(double sigma_px);
  unsigned taps() const noexcept { return taps_; }
  /// Pixels from reach() before floor(position) to reach() + 1 after it respond.
  int reach() const noexcept { return reach_; }
  /// point[j]: response of pixel floor(position) - reach() + j to a unit point at `position`; edge[j], if
  /// given: the share of a unit step at `position` that this pixel sees, 0 far to the left and 1 far to the
  /// right. Returns floor(position).
  int respond(double position_px, float* point, float* edge) const noexcept;

 private:
  int reach_ = 0;
  unsigned taps_ = 0;
  std::vector<float> point_, edge_;  // [phase][tap]
};

/// A small rectangle of signal, in grey levels before noise, with its derivatives by image position on
/// request.
class Patch {
 public:
  /// With room for 64 x 64 pixels: more than any marker needs that is not held in front of the lens.
  Patch();
  /// Covers x_min..x_max, y_min..y_max (inclusive), all zero. Allocates only when larger than ever before.
  void reset(int x_min_px, int y_min_px, int x_max_px, int y_max_px, bool with_gradient);

  /// Adds what the outline encloses at `grey` through the blur. By Green's theorem the blurred region is an
  /// integral along its outline, of which each point is a column times a row.
  void add_filled(const BlurKernel& kernel, std::span<const OutlinePoint> outline, double orientation,
                  double grey);
  /// Adds a point of light of that many grey levels in all.
  void add_point(const BlurKernel& kernel, double x_px, double y_px, double grey);

  int x_min_px() const noexcept { return x_min_; }
  int y_min_px() const noexcept { return y_min_; }
  int width_px() const noexcept { return width_; }
  int height_px() const noexcept { return height_; }
  const float* row(int y) const noexcept { return signal_.data() + offset(y); }
  const float* row_by_x(int y) const noexcept { return by_x_.data() + offset(y); }
  const float* row_by_y(int y) const noexcept { return by_y_.data() + offset(y); }

 private:
  std::size_t offset(int y) const noexcept {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_);
  }
  int x_min_ = 0, y_min_ = 0, width_ = 0, height_ = 0;
  bool gradient_ = false;
  std::vector<float> signal_, by_x_, by_y_, edge_row_;
};

}  // namespace glint::sim
