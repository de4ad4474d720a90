// SPDX-License-Identifier: MIT
// What one camera has seen of a board so far: which views are worth keeping, and what is still missing.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/calibrate/coverage.hpp"
#include "host/target/target.hpp"

namespace glint {

/// How much is wanted of the views of one camera.
struct BoardWants {
  std::size_t least_views = 5;  ///< fewer: no calibration
  std::size_t views = 20;       ///< enough, if they differ
  std::uint64_t per_cell = 4;   ///< corners in each cell of the coverage grid
  double covered = 0.8;         ///< share of the cells
  double tilt_rad = 0.6;  ///< how far the board is turned, from one extreme to the other, about each axis
  double least_tilt_rad = 0.17;  ///< largest angle between any two views below which nothing can be computed
  double least_square_px = 6.0;  ///< smaller squares are not measured well
  double board_across = 0.4;     ///< of the largest view: its share of the image's width or height
};

/// One view of the board: parallel lists.
struct BoardPoints {
  std::vector<std::uint32_t> points;  ///< indices into Target::points_in_target, rising
  std::vector<Eigen::Vector2d> pixels;
};

/// Why views that are all within that angle of one another will not do.
std::string parallel_sentence(double largest_turn_rad);

/// Thread-bound. What it says of the board's tilt rests on a first guess of the lens.
class BoardSession {
 public:
  BoardSession(const Target& board, std::uint32_t width_px, std::uint32_t height_px, BoardWants wants = {});

  /// Keeps the view if it shows something new: against every view that was kept, some corner is elsewhere by
  /// 3 % of the image's width. False if not.
  bool add(const BoardPoints& view);
  /// Whether add() would keep it.
  bool is_new(const BoardPoints& view) const;
  /// Keeps it in any case.
  void add_always(const BoardPoints& view);

  const std::vector<BoardPoints>& views() const noexcept { return views_; }
  const CoverageGrid& coverage() const noexcept { return coverage_; }
  /// Median over the views of the side of a square of the board in the image.
  double square_px() const;

  /// Why no calibration can come of this, each with what to do; empty: it can be tried.
  std::vector<std::string> blocking() const;
  /// What would make it better, most useful first; empty: it is enough. Holds what blocks, too.
  std::vector<std::string> missing() const;

 private:
  struct Tilts {
    double largest_turn_rad = 0.0;
    double left_right_rad = 0.0, up_down_rad = 0.0;  // range over the views
  };
  Tilts tilts() const;

  std::vector<Eigen::Vector2d> plane_;  // the board's points
  double square_m_ = 0.0;
  std::uint32_t width_px_, height_px_;
  BoardWants wants_;
  std::vector<BoardPoints> views_;
  std::vector<Eigen::Matrix3d> homographies_;  // of the views
  std::vector<double> square_px_;              // likewise
  double largest_share_ = 0.0;
  CoverageGrid coverage_;
};

}  // namespace glint
