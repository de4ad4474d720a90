// SPDX-License-Identifier: MIT
// Sums over pixels, and their solution by Cholesky's method.
#include "host/resolve/normal_equations.hpp"

#include <cmath>

namespace glint {

void NormalEquations::clear() noexcept {
  for (std::size_t i = 0; i < discs_; ++i) {
    for (std::size_t j = i; j < discs_; ++j) block_[i][j].fill(0.0f);
    right_[i].fill(0.0f);
  }
  dark_ = dark_right_ = 0.0f;
  grey_.fill(0.0);
  grey_right_.fill(0.0);
}

void NormalEquations::add_grey(std::size_t disc, double residual, double weight) noexcept {
  grey_[disc] += weight;
  grey_right_[disc] += weight * residual;
}

void NormalEquations::assemble() noexcept {
  const std::size_t last = kOfDisc * discs_;
  matrix_[last][last] = double{dark_};
  right_side_[last] = double{dark_right_};
  for (std::size_t j = 0; j < discs_; ++j) {
    matrix_[last][last] += double{block_[j][j][kRow * kRow - 1]};
    right_side_[last] += double{right_[j][kRow - 1]};
    for (std::size_t b = 0; b < kOfDisc; ++b) {
      const std::size_t row = kOfDisc * j + b;
      matrix_[last][row] = 0.0;
      for (std::size_t i = 0; i <= j; ++i) {
        matrix_[last][row] += double{block_[i][j][(kRow - 1) * kRow + b]};
        for (std::size_t a = 0; a < kOfDisc; ++a)
          matrix_[row][kOfDisc * i + a] = double{block_[i][j][a * kRow + b]};
      }
      right_side_[row] = double{right_[j][b]};
    }
    matrix_[kOfDisc * j + 2][kOfDisc * j + 2] += grey_[j];
    right_side_[kOfDisc * j + 2] += grey_right_[j];
  }
}

bool NormalEquations::solve() noexcept {
  constexpr double kSmallestPivot = 1e-5;  // of a diagonal scaled to 1
  assemble();
  const std::size_t n = unknowns();
  std::array<double, kMost> diagonal;
  for (std::size_t i = 0; i < n; ++i) diagonal[i] = matrix_[i][i];
  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      double sum = matrix_[i][j];
      for (std::size_t k = 0; k < j; ++k) sum -= matrix_[i][k] * matrix_[j][k];
      if (i != j) {
        matrix_[i][j] = sum / matrix_[j][j];
      } else {
        if (!(sum > kSmallestPivot * diagonal[i])) return false;
        matrix_[i][i] = std::sqrt(sum);
      }
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    double sum = right_side_[i];
    for (std::size_t k = 0; k < i; ++k) sum -= matrix_[i][k] * solution_[k];
    solution_[i] = sum / matrix_[i][i];
  }
  for (std::size_t i = n; i-- > 0;) {
    double sum = solution_[i];
    for (std::size_t k = i + 1; k < n; ++k) sum -= matrix_[k][i] * solution_[k];
    solution_[i] = sum / matrix_[i][i];
  }
  return true;
}

Eigen::Matrix2d NormalEquations::centre_covariance_px2(std::size_t disc) const noexcept {
  // Columns of the factor's inverse: the covariance is their scalar products.
  const std::size_t n = unknowns();
  std::array<std::array<double, kMost>, 2> column;
  for (std::size_t c = 0; c < 2; ++c) {
    const std::size_t begin = kOfDisc * disc + c;
    for (std::size_t i = 0; i < n; ++i) {
      double sum = i == begin ? 1.0 : 0.0;
      for (std::size_t k = begin; k < i; ++k) sum -= matrix_[i][k] * column[c][k];
      column[c][i] = i < begin ? 0.0 : sum / matrix_[i][i];
    }
  }
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();
  for (std::size_t i = 0; i < n; ++i) {
    covariance(0, 0) += column[0][i] * column[0][i];
    covariance(0, 1) += column[0][i] * column[1][i];
    covariance(1, 1) += column[1][i] * column[1][i];
  }
  covariance(1, 0) = covariance(0, 1);
  return covariance;
}

}  // namespace glint
