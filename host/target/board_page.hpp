// SPDX-License-Identifier: MIT
// A board on a page, at true scale, to be printed.
#pragma once

#include <string>
#include <string_view>

#include "host/target/board.hpp"

namespace glint {

struct PageSize {
  double width_mm = 297.0, height_mm = 210.0;
};

/// "a4", "a3", "a2", "a1", "a0", "letter", "tabloid", or "WIDTHxHEIGHTmm". The board is turned on its side
/// where it fits only so. Throws UsageError.
PageSize parse_page(std::string_view text);

/// The page with the board, a line of 100 mm to check the printer by, and the board's text to type into
/// commands. Throws Error: the board does not fit (both sizes are named); Charuco without OpenCV.
std::string board_svg(const BoardSpec& board, const PageSize& page);
/// The same as PDF, which asks viewers to print it unscaled.
std::string board_pdf(const BoardSpec& board, const PageSize& page);

}  // namespace glint
