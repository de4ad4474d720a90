// SPDX-License-Identifier: MIT
// The finders that exist where glint is built with OpenCV. Only for this module's sources.
#pragma once

#include <memory>

#include "host/target/board_finder.hpp"

namespace glint {

std::unique_ptr<BoardFinder> make_chessboard_finder(const BoardSpec& board,
                                                    const BoardFinderOptions& options);
std::unique_ptr<BoardFinder> make_charuco_finder(const BoardSpec& board, const BoardFinderOptions& options);

}  // namespace glint
