// SPDX-License-Identifier: MIT
// Which finder a board needs, and what stands in for them without OpenCV.
#include "host/target/board_finder.hpp"

#include "host/target/aruco.hpp"
#include "host/target/opencv_finders.hpp"

namespace glint {

#if GLINT_OPENCV

std::unique_ptr<BoardFinder> make_board_finder(const BoardSpec& board, const BoardFinderOptions& options) {
  if (board.kind == BoardKind::Charuco) return make_charuco_finder(board, options);
  return make_chessboard_finder(board, options);
}

bool have_board_finder() noexcept { return true; }

#else

std::unique_ptr<BoardFinder> make_board_finder(const BoardSpec&, const BoardFinderOptions&) {
  throw_no_opencv("finding boards");
}

bool have_board_finder() noexcept { return false; }

#endif

}  // namespace glint
