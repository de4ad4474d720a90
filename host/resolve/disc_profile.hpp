// SPDX-License-Identifier: MIT
// A bright disc through optical blur and pixels, as a function of the distance from its centre.
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace glint {

/// Response of a pixel to a disc of one radius: 1 inside, 0 outside, and the blurred edge tabulated between.
class DiscProfile {
 public:
  static constexpr int kSteps_per_sigma = 8;
  static constexpr double kReach_sigma = 3.25;  ///< beyond it an edge is taken for complete: to 0.0006
  static constexpr std::size_t kNodes = 2 * 26 + 1;
  static_assert(2.0 * kReach_sigma * kSteps_per_sigma + 1.0 == kNodes);

  struct Value {
    float share;         ///< of the disc's brightness
    float slope_over_r;  ///< its derivative by the distance from the centre, over that distance; 1/px^2
  };
  Value at(float distance_px) const noexcept {
    const float cell = (distance_px - first_px_) * nodes_per_px_;
    if (cell <= 0.0f) return {inner_, 0.0f};
    if (cell >= static_cast<float>(kNodes - 1)) return {0.0f, 0.0f};
    const auto i = static_cast<std::size_t>(static_cast<int>(cell));
    const float far = cell - static_cast<float>(i);
    return {share_[i] + far * (share_[i + 1] - share_[i]),
            slope_over_r_[i] + far * (slope_over_r_[i + 1] - slope_over_r_[i])};
  }
  /// Nothing of it is seen farther away than this.
  float reach_px() const noexcept { return reach_px_; }

 private:
  friend class DiscProfiles;
  float first_px_ = 0.0f, nodes_per_px_ = 1.0f, reach_px_ = 0.0f, inner_ = 1.0f;
  std::array<float, kNodes> share_, slope_over_r_;
};

/// Profiles of discs of all radii for one blur; made once.
class DiscProfiles {
 public:
  /// `psf_sigma_px`: of the optics. The pixel's square counts as a Gaussian of the same variance, 1/12: that
  /// is off by 0.001 of the brightness for a blur of 0.6 px.
  explicit DiscProfiles(double psf_sigma_px);

  double sigma_px() const noexcept { return sigma_px_; }
  DiscProfile of(double radius_px) const noexcept;

 private:
  struct Row {
    std::array<float, DiscProfile::kNodes> share, slope;
  };
  double sigma_px_;
  std::vector<Row> rows_;  // by radius
};

}  // namespace glint
