// SPDX-License-Identifier: MIT
// Pictures of one camera's residuals and samples, and histograms.
#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/coverage.hpp"
#include "host/calibrate/quality.hpp"

namespace glint {

/// Residuals in 16 x 10 cells of an image; outliers are left out. Medians, so that a stray one does not
/// colour a cell.
class ResidualGrid {
 public:
  static constexpr std::size_t kColumns = 16, kRows = 10;
  static constexpr std::uint64_t kLeast = 8;  ///< sightings without which a cell says nothing

  ResidualGrid(std::span<const PixelResidual> residuals, std::uint32_t width_px, std::uint32_t height_px);

  std::uint64_t count(std::size_t column, std::size_t row) const {
    return cells_[row * kColumns + column].count;
  }
  /// Of the residuals' lengths.
  double median_px(std::size_t column, std::size_t row) const {
    return cells_[row * kColumns + column].length_px;
  }
  /// Along each axis: what is systematic.
  const Eigen::Vector2d& shift_px(std::size_t column, std::size_t row) const {
    return cells_[row * kColumns + column].shift_px;
  }
  double width_px() const noexcept { return width_px_; }
  double height_px() const noexcept { return height_px_; }

 private:
  struct Cell {
    std::uint64_t count = 0;
    double length_px = 0.0;
    Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  };
  std::vector<Cell> cells_;
  double width_px_ = 1, height_px_ = 1;
};

/// How all cameras of a report are drawn alike.
struct ResidualScale {
  double top_px = 1.0;     ///< end of the colours
  double arrow_px = 0.1;   ///< a shift of this length ...
  double magnified = 1.0;  ///< ... is drawn so many times as long as it is
};
ResidualScale residual_scale(std::span<const ResidualGrid> cameras);

/// Colour: median residual of each cell. Arrow: its shift, magnified.
std::string residual_map_svg(const ResidualGrid& grid, const ResidualScale& scale);
/// Number of samples in each cell of the coverage grid.
std::string coverage_svg(const CoverageGrid& grid, double height_over_width);

/// Bars of `values`; `outline`, if there is any, as a line over them. Each adds up to 100 %. What lies
/// outside low..high counts for the outermost bar; what is no number for none.
struct Histogram {
  std::vector<double> values, outline;
  double low = 0.0, high = 1.0;
  double width = 520;      ///< of the picture, in user units
  std::string unit, what;  ///< below the axis; for those who do not see the picture
  std::vector<std::pair<std::string, double>> marks;  ///< lines with words
};
std::string histogram_svg(const Histogram& histogram);

}  // namespace glint
