// SPDX-License-Identifier: MIT
// Finds a printed board in a picture.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include <Eigen/Core>

#include "host/target/board.hpp"

namespace glint {

/// 8-bit grey, borrowed.
struct GreyPicture {
  const std::uint8_t* pixels = nullptr;
  std::uint32_t width_px = 0, height_px = 0, stride_bytes = 0;
};

struct BoardCorner {
  std::uint32_t point = 0;  ///< index into board_target().points_in_target
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
};

enum class BoardFinding : std::uint8_t {
  None,
  Found,
  Mirrored,    ///< the board is there, but as in a mirror: no corners. Only Charuco boards tell
  OtherLayout  ///< its markers are arranged as with BoardSpec::legacy the other way round: no corners
};

struct BoardView {
  BoardFinding finding = BoardFinding::None;
  bool inverted = false;             ///< white on black; its corners are as good
  std::vector<BoardCorner> corners;  ///< in order of their points; at least kFewestCorners, or none
};

/// What a pose can be found from with something to spare.
inline constexpr std::size_t kFewestCorners = 6;

/// Thread-bound. Corners are saddle points of the grey levels, found to a few hundredths of a pixel; (0,0) is
/// the centre of the first pixel.
class BoardFinder {
 public:
  virtual ~BoardFinder() = default;
  /// Throws Error if OpenCV refuses the picture.
  virtual BoardView find(const GreyPicture& picture) = 0;
};

struct BoardFinderOptions {
  /// How far to each side of a corner the picture is looked at, 2 to 50; 0: as far as nothing else comes in,
  /// at most 11 (Charuco: 10). A fixed one is for comparison with other tools: where it holds the next
  /// corner, this one is wrong.
  int reach_px = 0;
};

/// Throws Error where glint was built without OpenCV.
std::unique_ptr<BoardFinder> make_board_finder(const BoardSpec& board,
                                               const BoardFinderOptions& options = {});

/// Whether glint was built with OpenCV.
bool have_board_finder() noexcept;

}  // namespace glint
