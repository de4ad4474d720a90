// SPDX-License-Identifier: MIT
// Boards as the simulated cameras need them.
#pragma once

#include "host/sim/board_view.hpp"
#include "host/target/board.hpp"

namespace glint::testing {

/// With a margin of a square all around, or more.
inline sim::PrintedBoard printed(const BoardSpec& board) {
  const BoardPattern pattern = board_pattern(board);
  const Eigen::Vector2d margin = Eigen::Vector2d::Constant(board.square_m);
  return {{pattern.squares.min() - margin, pattern.squares.max() + margin}, pattern.black};
}

}  // namespace glint::testing
