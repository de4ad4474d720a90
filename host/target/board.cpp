// SPDX-License-Identifier: MIT
// Boards from words, and their geometry.
#include "host/target/board.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "host/base/error.hpp"
#include "host/target/marker_bits.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kFewest = 3, kMost = 50;  // squares along a side

std::vector<std::string_view> words_of(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const auto colon = text.find(':');
    words.push_back(text.substr(0, colon));
    if (colon == std::string_view::npos) return words;
    text.remove_prefix(colon + 1);
  }
}

template <typename Number>
std::optional<Number> number_of(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

/// Parses one board; the text is for messages.
class BoardWords {
 public:
  explicit BoardWords(std::string_view text) : text_(text), words_(words_of(text)) {}

  BoardSpec parse() const {
    if (words_[0] == "chessboard") return chessboard();
    if (words_[0] == "charuco") return charuco();
    fail("must begin with chessboard: or charuco:");
  }

 private:
  static constexpr const char* kForms =
      "; a board is chessboard:9x6:25mm (inner corners, square) or charuco:5x4:54mm:40.5mm:4X4_1000 "
      "(squares, "
      "square, marker, dictionary)";
  [[noreturn]] void fail(const std::string& what) const {
    throw UsageError("board \"" + text_ + "\": " + what + kForms);
  }

  BoardSpec chessboard() const {
    if (words_.size() != 3) fail("needs two things after chessboard:");
    BoardSpec board;
    const auto [across, down] = counts("inner corners");
    board.squares_across = across + 1;
    board.squares_down = down + 1;
    check_counts(board);
    board.square_m = length(words_[2], "square");
    return board;
  }

  BoardSpec charuco() const {
    if (words_.size() != 5 && !(words_.size() == 6 && words_[5] == "legacy"))
      fail("needs four things after charuco: (and perhaps :legacy)");
    BoardSpec board;
    board.kind = BoardKind::Charuco;
    std::tie(board.squares_across, board.squares_down) = counts("squares");
    check_counts(board);
    board.square_m = length(words_[2], "square");
    board.marker_m = length(words_[3], "marker");
    // Nearer to the square's edge a marker's frame would run into the black squares and not be found.
    if (!(board.marker_m >= 0.3 * board.square_m && board.marker_m <= 0.9 * board.square_m))
      fail("a marker's side must be 0.3 to 0.9 of a square's");
    board.dictionary = dictionary_name(words_[4]);
    const std::uint32_t known = markers_in(board.dictionary);
    if (known == 0) {
      fail("no dictionary \"" + std::string(words_[4]) +
           "\" (4X4, 5X5, 6X6 or 7X7 with _50, _100, _250 or _1000; ARUCO_ORIGINAL; APRILTAG_16h5, _25h9, "
           "_36h10 or _36h11)");
    }
    board.legacy = words_.size() == 6;
    const std::size_t needed = board_markers(board).size();
    if (needed > known) {
      fail("needs " + std::to_string(needed) + " markers; " + board.dictionary + " has " +
           std::to_string(known));
    }
    return board;
  }

  std::pair<std::uint32_t, std::uint32_t> counts(const char* of_what) const {
    const std::string_view word = words_[1];
    const auto cross = word.find('x');
    if (cross != std::string_view::npos) {
      const auto across = number_of<std::uint32_t>(word.substr(0, cross));
      const auto down = number_of<std::uint32_t>(word.substr(cross + 1));
      if (across && down && *across <= kMost && *down <= kMost) return {*across, *down};
    }
    fail("\"" + std::string(word) + "\" must be the number of " + of_what +
         " across and down, like 9x6, each at most " + std::to_string(kMost));
  }

  void check_counts(const BoardSpec& board) const {
    if (board.squares_across < kFewest || board.squares_down < kFewest || board.squares_across > kMost ||
        board.squares_down > kMost) {
      fail("must be of " + std::to_string(kFewest) + " to " + std::to_string(kMost) +
           " squares across and down");
    }
  }

  double length(std::string_view word, const char* of_what) const {
    constexpr std::array<std::pair<std::string_view, double>, 3> kUnits{
        {{"mm", 1000.0}, {"cm", 100.0}, {"m", 1.0}}};
    for (const auto& [unit, per_m] : kUnits) {
      if (!word.ends_with(unit)) continue;
      const auto value = number_of<double>(word.substr(0, word.size() - unit.size()));
      if (value && *value / per_m >= 1e-3 && *value / per_m <= 2.0) return *value / per_m;
      break;
    }
    fail("\"" + std::string(word) + "\" must be the side of a " + of_what +
         " with its unit, like 25mm, 2.5cm or 0.025m, from 1 mm to 2 m");
  }

  std::string text_;
  std::vector<std::string_view> words_;
};

std::string millimetres(double length_m) {
  // What was typed, though thousandths are no binary fractions.
  char text[32];
  const double rounded = std::round(length_m * 1e9) / 1e6;
  return std::string(text, std::to_chars(text, text + sizeof text, rounded).ptr) + "mm";
}

}  // namespace

BoardSpec parse_board(std::string_view text) { return BoardWords(text).parse(); }

std::string to_text(const BoardSpec& board) {
  if (board.kind == BoardKind::Chessboard) {
    return "chessboard:" + std::to_string(board.corners_across()) + "x" +
           std::to_string(board.corners_down()) + ":" + millimetres(board.square_m);
  }
  return "charuco:" + std::to_string(board.squares_across) + "x" + std::to_string(board.squares_down) + ":" +
         millimetres(board.square_m) + ":" + millimetres(board.marker_m) + ":" + board.dictionary +
         (board.legacy ? ":legacy" : "");
}

Target board_target(const BoardSpec& board) {
  Target target;
  target.kind = TargetKind::Board;
  target.name = to_text(board);
  target.points_in_target.clear();
  for (std::uint32_t y = 0; y < board.corners_down(); ++y)
    for (std::uint32_t x = 0; x < board.corners_across(); ++x)
      target.points_in_target.emplace_back(x * board.square_m, y * board.square_m, 0.0);
  return target;
}

std::vector<BoardMarker> board_markers(const BoardSpec& board) {
  std::vector<BoardMarker> markers;
  if (board.kind != BoardKind::Charuco) return markers;
  for (std::uint32_t row = 0; row < board.squares_down; ++row) {
    for (std::uint32_t column = 0; column < board.squares_across; ++column) {
      if (!board.black(column, row))
        markers.push_back({static_cast<std::uint32_t>(markers.size()), column, row});
    }
  }
  return markers;
}

BoardPattern board_pattern(const BoardSpec& board) {
  const double side = board.square_m;
  const auto corner_of = [side](std::uint32_t column, std::uint32_t row) {
    return Eigen::Vector2d((column - 1.0) * side, (row - 1.0) * side);
  };
  BoardPattern pattern;
  pattern.squares = {corner_of(0, 0), corner_of(board.squares_across, board.squares_down)};
  for (std::uint32_t row = 0; row < board.squares_down; ++row)
    for (std::uint32_t column = 0; column < board.squares_across; ++column)
      if (board.black(column, row))
        pattern.black.emplace_back(corner_of(column, row), corner_of(column + 1, row + 1));
  for (const BoardMarker& marker : board_markers(board)) {
    const MarkerBits bits = marker_bits(board.dictionary, marker.id);
    const double cell = board.marker_m / bits.side;
    const Eigen::Vector2d first =
        corner_of(marker.column, marker.row) + Eigen::Vector2d::Constant(0.5 * (side - board.marker_m));
    for (std::uint32_t y = 0; y < bits.side; ++y) {
      for (std::uint32_t x = 0; x < bits.side;) {  // neighbouring black cells of a row are one rectangle
        std::uint32_t end = x;
        while (end < bits.side && bits.black[y * bits.side + end]) ++end;
        if (end > x)
          pattern.black.emplace_back(first + cell * Eigen::Vector2d(x, y),
                                     first + cell * Eigen::Vector2d(end, y + 1));
        x = end + 1;
      }
    }
  }
  return pattern;
}

}  // namespace glint
