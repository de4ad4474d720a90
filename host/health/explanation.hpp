// SPDX-License-Identifier: MIT
// What explains a camera's offsets best: nothing is wrong, the camera was turned, or it exposes at another
// time.
#pragma once

#include <cstdint>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"
#include "host/health/comparison.hpp"

namespace glint::health {

/// How well an assumption accounts for all comparisons of a window.
struct Account {
  /// Logarithm of how much likelier the blobs are than if none of them was of its point (the association-free
  /// likelihood of Bar-Shalom, Daum and Huang, The probabilistic data association filter, IEEE Control
  /// Systems 29(6), 2009). Comparisons in the same part of the image count as one, their mean: a marker that
  /// lingers shows the same thing again and again.
  double log_likelihood = 0.0;
  /// The same with the assumption's tolerances alone, without what it moves: looser limits explain
  /// everything.
  double log_likelihood_unmoved = 0.0;
  std::uint32_t seen = 0;          ///< comparisons with any blob near
  std::uint32_t explained = 0;     ///< of these, with one where the assumption puts it
  std::uint32_t gained = 0;        ///< of these, how many have none where it should be if all were well
  std::uint32_t gained_cells = 0;  ///< in so many parts of the image
  double offset_px = 0.0;          ///< root mean square of what the assumption adds
};

struct TurnAccount : Account {
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();  ///< as CameraState::turn_rad
};

struct DelayAccount : Account {
  double late_s = 0.0;
};

/// Fits by hypotheses from one or two comparisons each (Fischler and Bolles, RANSAC, CACM 24(6), 1981), then
/// least squares over what agrees with the best. `noise` >= 1 multiplies the standard deviations.
class Explainer {
 public:
  explicit Explainer(const CameraCalibration& calibration)
      : fx_px_(calibration.fx_px), fy_px_(calibration.fy_px) {}

  Account all_is_well(const ComparisonWindow& window, double noise) const noexcept;
  TurnAccount turned(const ComparisonWindow& window, double noise) noexcept;
  DelayAccount delayed(const ComparisonWindow& window, double noise) noexcept;

 private:
  std::size_t pick(std::size_t count) noexcept;

  double fx_px_, fy_px_;
  std::uint64_t random_ = 0x9e3779b97f4a7c15u;
};

/// A blob is where it should be within four standard deviations: chi-square of two degrees of freedom exceeds
/// this three times in 10,000.
inline constexpr double kNearChi2 = 16.0;

/// Squared distance, in standard deviations, of the nearest blob from where it should be if all is well.
double misfit2(const Comparison& comparison, double noise) noexcept;

}  // namespace glint::health
