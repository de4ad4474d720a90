// SPDX-License-Identifier: MIT
// Boards from words, their points and pattern, and what is refused.
#include "host/target/board.hpp"

#include <algorithm>
#include <set>

#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/target/board_finder.hpp"
#include "host/target/marker_bits.hpp"

namespace glint {
namespace {

std::string complaint(const std::string& text) {
  try {
    parse_board(text);
  } catch (const UsageError& e) {
    const std::string said = e.what();
    return said.substr(0, said.find("; a board is"));
  }
  return "";
}

TEST(Board, IsParsedAndWrittenAsItWasTyped) {
  for (const char* const text :
       {"chessboard:9x6:25mm", "chessboard:2x2:0.1m", "charuco:5x4:54mm:40.5mm:4X4_1000",
        "charuco:8x6:33.3mm:24mm:5X5_100:legacy", "charuco:3x3:2mm:1mm:ARUCO_ORIGINAL",
        "charuco:8x5:30mm:22mm:APRILTAG_36h11"}) {
    const BoardSpec board = parse_board(text);
    EXPECT_EQ(to_text(parse_board(to_text(board))), to_text(board));
  }
  EXPECT_EQ(to_text(parse_board("chessboard:9x6:2.5cm")), "chessboard:9x6:25mm");
  EXPECT_EQ(to_text(parse_board("charuco:5x4:0.054m:40.5mm:dict_4x4_1000")),
            "charuco:5x4:54mm:40.5mm:4X4_1000");
  for (const char* const typed : {"APRILTAG_36h11", "apriltag_36H11", "DICT_APRILTAG_36h11"}) {
    EXPECT_EQ(to_text(parse_board(std::string("charuco:8x5:30mm:22mm:") + typed)),
              "charuco:8x5:30mm:22mm:APRILTAG_36h11");
  }
  const BoardSpec chessboard = parse_board("chessboard:9x6:25mm");
  EXPECT_EQ(chessboard.squares_across, 10u);
  EXPECT_EQ(chessboard.squares_down, 7u);
  EXPECT_EQ(chessboard.corners(), 54u);
  EXPECT_EQ(chessboard.square_m, 0.025);
  const BoardSpec charuco = parse_board("charuco:5x4:54mm:40.5mm:4X4_1000");
  EXPECT_EQ(charuco.corners(), 12u);
  EXPECT_EQ(charuco.marker_m, 0.0405);
}

TEST(Board, SaysWhatIsWrong) {
  EXPECT_EQ(complaint("circles:4x11:20mm"),
            "board \"circles:4x11:20mm\": must begin with chessboard: or charuco:");
  EXPECT_EQ(complaint("chessboard:9x6"), "board \"chessboard:9x6\": needs two things after chessboard:");
  EXPECT_EQ(complaint("chessboard:9x6:25"),
            "board \"chessboard:9x6:25\": \"25\" must be the side of a square with its unit, like 25mm, "
            "2.5cm or 0.025m, "
            "from 1 mm to 2 m");
  EXPECT_NE(complaint("chessboard:9x6:25m").find("from 1 mm to 2 m"), std::string::npos);
  EXPECT_NE(complaint("chessboard:9x6:0mm").find("from 1 mm to 2 m"), std::string::npos);
  EXPECT_NE(complaint("chessboard:9x6:nanmm").find("from 1 mm to 2 m"), std::string::npos);
  EXPECT_NE(complaint("chessboard:9:25mm").find("must be the number of inner corners across and down"),
            std::string::npos);
  EXPECT_NE(complaint("chessboard:1x6:25mm").find("3 to 50 squares"), std::string::npos);
  EXPECT_NE(complaint("chessboard:4000000000x6:25mm").find("at most 50"), std::string::npos);
  EXPECT_NE(complaint("charuco:5x4:54mm:54mm:4X4_1000").find("0.3 to 0.9"), std::string::npos);
  EXPECT_NE(complaint("charuco:5x4:54mm:40mm:8X8_50").find("no dictionary \"8X8_50\""), std::string::npos);
  EXPECT_NE(complaint("charuco:12x12:20mm:15mm:4X4_50").find("needs 72 markers; 4X4_50 has 50"),
            std::string::npos);
  EXPECT_NE(complaint("charuco:9x8:20mm:15mm:apriltag_25h9").find("needs 36 markers; APRILTAG_25h9 has 35"),
            std::string::npos);
  EXPECT_NE(complaint("charuco:5x4:54mm:40mm:4X4_50:new").find("needs four things"), std::string::npos);
}

TEST(Board, PointsAreTheInnerCornersRowByRow) {
  const Target target = board_target(parse_board("chessboard:9x6:25mm"));
  EXPECT_EQ(target.kind, TargetKind::Board);
  EXPECT_EQ(target.name, "chessboard:9x6:25mm");
  ASSERT_EQ(target.points_in_target.size(), 54u);
  EXPECT_EQ(target.points_in_target[0], Eigen::Vector3d(0, 0, 0));
  EXPECT_TRUE(target.points_in_target[8].isApprox(Eigen::Vector3d(0.2, 0, 0)));
  EXPECT_TRUE(target.points_in_target[53].isApprox(Eigen::Vector3d(0.2, 0.125, 0)));
}

TEST(Board, EachInnerCornerHasTwoBlackSquaresOpposite) {
  const BoardSpec board = parse_board("chessboard:9x6:25mm");
  const BoardPattern pattern = board_pattern(board);
  EXPECT_EQ(pattern.black.size(), 35u);
  EXPECT_TRUE(pattern.squares.min().isApprox(Eigen::Vector2d(-0.025, -0.025)));
  EXPECT_TRUE(pattern.squares.max().isApprox(Eigen::Vector2d(0.225, 0.15)));
  const auto black = [&](double x, double y) {
    return std::any_of(pattern.black.begin(), pattern.black.end(),
                       [&](const Eigen::AlignedBox2d& box) { return box.contains(Eigen::Vector2d(x, y)); });
  };
  for (const Eigen::Vector3d& p : board_target(board).points_in_target) {
    const double d = 0.006;
    EXPECT_EQ(black(p.x() - d, p.y() - d), black(p.x() + d, p.y() + d));
    EXPECT_NE(black(p.x() - d, p.y() - d), black(p.x() + d, p.y() - d));
  }
  EXPECT_TRUE(black(-0.01, -0.01)) << "the upper left square is black";
}

TEST(Board, TellsWhetherItLooksTheSameHalfTurned) {
  EXPECT_TRUE(parse_board("chessboard:9x6:25mm").orientation_known());
  EXPECT_FALSE(parse_board("chessboard:8x6:25mm").orientation_known());
  EXPECT_TRUE(parse_board("charuco:8x6:33mm:24mm:5X5_100").orientation_known());
}

TEST(Board, MarkersAreInTheWhiteSquares) {
  for (const char* const text : {"charuco:8x5:40mm:30mm:5X5_100", "charuco:6x4:40mm:30mm:5X5_100:legacy"}) {
    const BoardSpec board = parse_board(text);
    const auto markers = board_markers(board);
    EXPECT_EQ(markers.size(), board.squares_across * board.squares_down / 2);
    for (std::size_t i = 0; i < markers.size(); ++i) {
      EXPECT_EQ(markers[i].id, i);
      EXPECT_FALSE(board.black(markers[i].column, markers[i].row));
    }
  }
  EXPECT_EQ(board_markers(parse_board("charuco:6x4:40mm:30mm:5X5_100"))[0].column, 1u);
  EXPECT_EQ(board_markers(parse_board("charuco:6x4:40mm:30mm:5X5_100:legacy"))[0].column, 0u);
  EXPECT_EQ(board_markers(parse_board("charuco:6x5:40mm:30mm:5X5_100:legacy"))[0].column, 1u);
}

TEST(Board, MarkersDifferFromOneAnotherHoweverTheyAreTurned) {
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  for (const char* const dictionary : {"4X4_50", "6X6_250", "ARUCO_ORIGINAL", "APRILTAG_16h5",
                                       "APRILTAG_25h9", "APRILTAG_36h10", "APRILTAG_36h11"}) {
    std::set<std::vector<bool>> known;
    for (std::uint32_t id = 0; id < std::min(50u, markers_in(dictionary)); ++id) {
      MarkerBits bits = marker_bits(dictionary, id);
      ASSERT_EQ(bits.black.size(), bits.side * bits.side);
      for (std::uint32_t i = 0; i < bits.side; ++i) {
        EXPECT_TRUE(bits.black[i] && bits.black[i * bits.side] && bits.black[i * bits.side + bits.side - 1]);
      }
      for (int turn = 0; turn < 4; ++turn) {
        EXPECT_TRUE(known.insert(bits.black).second) << dictionary << " " << id;
        std::vector<bool> turned(bits.black.size());
        for (std::uint32_t y = 0; y < bits.side; ++y)
          for (std::uint32_t x = 0; x < bits.side; ++x)
            turned[x * bits.side + bits.side - 1 - y] = bits.black[y * bits.side + x];
        bits.black = turned;
      }
    }
  }
}

TEST(Board, AprilTagsAreThoseOfTheFamily) {
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  // The first code of family 36h11 as its authors publish it, row by row with 1 for white; OpenCV's markers
  // are turned by half against theirs.
  constexpr std::uint64_t kFirst = 0xd5d628584;
  const MarkerBits bits = marker_bits("APRILTAG_36h11", 0);
  ASSERT_EQ(bits.side, 8u);
  for (std::uint32_t y = 0; y < 6; ++y)
    for (std::uint32_t x = 0; x < 6; ++x)
      EXPECT_EQ(bits.black[(y + 1) * 8 + x + 1], ((kFirst >> (6 * y + x)) & 1) == 0) << x << " " << y;
}

TEST(Board, SizesOfDictionaries) {
  EXPECT_EQ(markers_in("4X4_50"), 50u);
  EXPECT_EQ(markers_in("7X7_1000"), 1000u);
  EXPECT_EQ(markers_in("ARUCO_ORIGINAL"), 1024u);
  EXPECT_EQ(markers_in("4X4_51"), 0u);
  EXPECT_EQ(markers_in("APRILTAG_16h5"), 30u);
  EXPECT_EQ(markers_in("APRILTAG_36h11"), 587u);
}

}  // namespace
}  // namespace glint
