// SPDX-License-Identifier: MIT
// Small images of discs that hide one another, exact below the pixel, with the noise of a sensor.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "host/resolve/disc_fit.hpp"
#include "host/sim/random.hpp"

namespace glint::testing {

/// A disc (or ellipse: see ExpectedDisc) as it really is.
struct TrueDisc {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Matrix2d shape_px2 = Eigen::Matrix2d::Identity();
  double grey = 100.0;
  double distance_m = 1.0;
  /// Something unknown hides what lies on this side: v with v.dot(edge_normal) > edge_px, v from the centre.
  Eigen::Vector2d edge_normal = Eigen::Vector2d::UnitX();
  double edge_px = 1e9;
};

TrueDisc round_disc(const Eigen::Vector2d& centre_px, double radius_px, double grey, double distance_m = 1.0);

/// How far a straight edge lies from the centre of a unit disc if it hides that share of its area.
double edge_that_hides(double share);

struct DrawnImage {
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<double> mean;  ///< without noise
  std::vector<std::uint8_t> pixels;
  gpu::ImageView view() const noexcept { return {pixels.data(), width_px, height_px, width_px}; }
  PixelBox box() const noexcept {
    return {0, 0, static_cast<int>(width_px) - 1, static_cast<int>(height_px) - 1};
  }
};

/// Draws discs over `dark_grey` through the blur of `noise`; adds its noise, rounds and clips.
DrawnImage draw(std::uint32_t width_px, std::uint32_t height_px, double dark_grey,
                std::span<const TrueDisc> discs, const PixelNoise& noise, sim::Random& random,
                const sim::NormalTable& normal);

/// Covariance that no unbiased estimate of the centres can beat when brightnesses and background are unknown
/// as well: by differences of noiseless images. x0 y0 x1 y1 ...
Eigen::MatrixXd smallest_covariance_px2(std::uint32_t width_px, std::uint32_t height_px, double dark_grey,
                                        std::span<const TrueDisc> discs, const PixelNoise& noise);

}  // namespace glint::testing
