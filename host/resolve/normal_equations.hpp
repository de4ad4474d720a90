// SPDX-License-Identifier: MIT
// Normal equations of a fit of discs: three unknowns each and one background.
#pragma once

#include <array>
#include <cstddef>

#include <Eigen/Core>

#include "host/resolve/disc_model.hpp"

namespace glint {

/// The same sums for one disc alone: few enough to stay in registers.
struct OneDiscSums {
  static constexpr std::size_t kRow = 4;  // x, y, grey, background
  std::array<float, kRow * kRow> block{};
  std::array<float, kRow> right{};

  void add(float by_x, float by_y, float by_grey, float residual, float weight) noexcept {
    const std::array<float, kRow> row{by_x, by_y, by_grey, 1.0f};
    for (std::size_t a = 0; a < kRow; ++a) {
      const float weighted = weight * row[a];
      right[a] += weighted * residual;
      for (std::size_t b = 0; b < kRow; ++b) block[a * kRow + b] += weighted * row[b];
    }
  }
};

class NormalEquations {
 public:
  explicit NormalEquations(std::size_t discs) noexcept : discs_(discs) {}

  void clear() noexcept;
  /// A pixel that shows `residual` more than the model, with its weight (1 / grey^2).
  void add(const PixelModel::Pixel& pixel, float residual, float weight) noexcept {
    float rows[kMaxDiscs][kRow];
    for (std::size_t n = 0; n < pixel.discs; ++n) {
      float* row = rows[n];
      row[0] = pixel.by_x[n], row[1] = pixel.by_y[n], row[2] = pixel.by_grey[n],
      row[3] = n == 0 ? 1.0f : 0.0f;
      const float weighted_residual = weight * residual;
      for (std::size_t b = 0; b < kRow; ++b) right_[pixel.disc[n]][b] += weighted_residual * row[b];
      for (std::size_t k = 0; k <= n; ++k) {
        float* sum = block_[pixel.disc[k]][pixel.disc[n]].data();
        for (std::size_t a = 0; a < kRow; ++a) {
          const float weighted = weight * rows[k][a];
          for (std::size_t b = 0; b < kRow; ++b) sum[a * kRow + b] += weighted * row[b];
        }
      }
    }
  }
  void add(const OneDiscSums& sums) noexcept {
    for (std::size_t k = 0; k < sums.block.size(); ++k) block_[0][0][k] += sums.block[k];
    for (std::size_t k = 0; k < sums.right.size(); ++k) right_[0][k] += sums.right[k];
  }
  /// Pixels that see no disc: sums of their weights and of weight times residual.
  void add_dark(float weight, float weighted_residual) noexcept {
    dark_ += weight;
    dark_right_ += weighted_residual;
  }
  /// A measurement of one disc's brightness.
  void add_grey(std::size_t disc, double residual, double weight) noexcept;
  /// False: the unknowns do not follow from what was added. The steps are valid only after true.
  bool solve() noexcept;

  Eigen::Vector2d centre_step(std::size_t disc) const noexcept {
    return {solution_[kOfDisc * disc], solution_[kOfDisc * disc + 1]};
  }
  double grey_step(std::size_t disc) const noexcept { return solution_[kOfDisc * disc + 2]; }
  double background_step() const noexcept { return solution_[kOfDisc * discs_]; }
  /// Covariance of a centre if every weight is one over a variance.
  Eigen::Matrix2d centre_covariance_px2(std::size_t disc) const noexcept;

 private:
  static constexpr std::size_t kOfDisc = 3, kMost = kOfDisc * kMaxDiscs + 1;
  // Sums of products stand in blocks of 4 x 4, one for each pair of discs: x, y, grey of the one by x, y,
  // grey of the other. The fourth row and column are the background's; of the discs that a pixel sees only
  // the first carries it.
  static constexpr std::size_t kRow = 4;
  using Block = std::array<float, kRow * kRow>;
  std::size_t unknowns() const noexcept { return kOfDisc * discs_ + 1; }
  void assemble() noexcept;

  std::size_t discs_;
  std::array<std::array<Block, kMaxDiscs>, kMaxDiscs> block_;  // [i][j], i <= j
  std::array<std::array<float, kRow>, kMaxDiscs> right_;
  float dark_ = 0.0f, dark_right_ = 0.0f;  // pixels that see none
  std::array<double, kMaxDiscs> grey_{}, grey_right_{};
  std::array<std::array<double, kMost>, kMost> matrix_;  // after solve(): its Cholesky factor
  std::array<double, kMost> right_side_, solution_;
};

}  // namespace glint
