// SPDX-License-Identifier: MIT
// Printed boards: what the command line says of them, their points, and what is printed in black.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "host/target/target.hpp"

namespace glint {

enum class BoardKind : std::uint8_t { Chessboard, Charuco };

/// A chessboard, with or without ArUco or AprilTag markers in its white squares.
struct BoardSpec {
  BoardKind kind = BoardKind::Chessboard;
  std::uint32_t squares_across = 10, squares_down = 7;  ///< on the page, black and white counted
  double square_m = 0.025;
  double marker_m = 0.0;   ///< Charuco: side of a marker, its black frame included
  std::string dictionary;  ///< Charuco: as dictionary_name() writes it, "4X4_50" or "APRILTAG_36h11"
  /// Charuco: the square in the upper left corner is white if squares_down is even, as OpenCV before 4.7
  /// prints it; else it is always black. Makes no difference if squares_down is odd.
  bool legacy = false;

  std::uint32_t corners_across() const noexcept { return squares_across - 1; }
  std::uint32_t corners_down() const noexcept { return squares_down - 1; }
  std::uint32_t corners() const noexcept { return corners_across() * corners_down(); }
  /// Column and row counted on the page, from 0 in the upper left corner.
  bool black(std::uint32_t column, std::uint32_t row) const noexcept {
    const bool white_first = legacy && kind == BoardKind::Charuco && squares_down % 2 == 0;
    return (column + row) % 2 == (white_first ? 1u : 0u);
  }
  /// Whether the picture of a half turned board differs from that of the board: only then is it known, from
  /// one camera to the next, which corner is which.
  bool orientation_known() const noexcept {
    return kind == BoardKind::Charuco || (squares_across + squares_down) % 2 == 1;
  }
};

/// "chessboard:9x6:25mm": INNER CORNERS across and down, side of a square;
/// "charuco:5x4:54mm:40.5mm:4X4_1000": SQUARES across and down, side of a square, of a marker, dictionary,
/// and
/// ":legacy" where BoardSpec::legacy is meant. Lengths end in mm, cm or m. Throws UsageError saying what is
/// wrong.
BoardSpec parse_board(std::string_view text);
/// The same as text; parse_board() gives it back.
std::string to_text(const BoardSpec& board);

/// The inner corners, row by row from the upper left one, which is the origin. x points right on the page, y
/// down and z away from who looks at it, so that a camera that faces an upright board is turned like it.
Target board_target(const BoardSpec& board);

/// What is printed in black, in the target's frame and metres; rectangles may touch.
struct BoardPattern {
  Eigen::AlignedBox2d squares;  ///< the outline of all squares; a margin of white must follow
  std::vector<Eigen::AlignedBox2d> black;
};
/// Throws Error for Charuco where glint was built without OpenCV, which knows the markers.
BoardPattern board_pattern(const BoardSpec& board);

/// One marker of a Charuco board: `id` in its dictionary, and the white square that it is in.
struct BoardMarker {
  std::uint32_t id = 0, column = 0, row = 0;
};
/// In the order of their numbers, which run along the rows of the page.
std::vector<BoardMarker> board_markers(const BoardSpec& board);

}  // namespace glint
