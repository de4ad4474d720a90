// SPDX-License-Identifier: MIT
// Pages: true scale, whole files, and boards that do not fit.
#include "host/target/board_page.hpp"

#include <cstdio>
#include <cstdlib>
#include <string>

#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/target/board_finder.hpp"

namespace glint {
namespace {

std::string complaint(const std::string& board, const std::string& page) {
  try {
    board_svg(parse_board(board), parse_page(page));
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

TEST(BoardPage, SvgIsAtTrueScaleAndSaysWhatItIs) {
  const std::string svg = board_svg(parse_board("chessboard:9x6:25mm"), parse_page("a4"));
  EXPECT_NE(svg.find("width=\"297.0000mm\" height=\"210.0000mm\" viewBox=\"0 0 297.0000 210.0000\""),
            std::string::npos);
  // The upper left square: (297 - 250) / 2 from the left, (210 - 14 - 175) / 2 from above; 25 mm wide.
  EXPECT_NE(svg.find("M23.5000 10.5000h25.0000v25.0000h-25.0000z"), std::string::npos);
  EXPECT_NE(svg.find("h100.0000v0.2000"), std::string::npos) << "the ruler";
  EXPECT_NE(svg.find(">chessboard:9x6:25mm "), std::string::npos);
}

TEST(BoardPage, APdfsTableLeadsToItsObjects) {
  const std::string pdf = board_pdf(parse_board("chessboard:9x6:25mm"), parse_page("letter"));
  EXPECT_TRUE(pdf.starts_with("%PDF-1."));
  EXPECT_TRUE(pdf.ends_with("%%EOF\n"));
  EXPECT_NE(pdf.find("/PrintScaling /None"), std::string::npos);
  EXPECT_NE(pdf.find("/MediaBox [0 0 792.0000 612.0000]"), std::string::npos);
  const std::size_t start = std::stoul(pdf.substr(pdf.find("startxref\n") + 10));
  ASSERT_EQ(pdf.substr(start, 9), "xref\n0 6\n");
  for (std::size_t n = 1; n <= 5; ++n) {
    const std::string row = pdf.substr(start + 9 + 20 * n, 20);
    EXPECT_TRUE(row.ends_with(" 00000 n \n")) << row;
    const std::string object = std::to_string(n) + " 0 obj\n";
    EXPECT_EQ(pdf.substr(std::stoul(row), object.size()), object);
  }
  const std::size_t length_at = pdf.find("/Length ") + 8, stream = pdf.find("stream\n") + 7;
  EXPECT_EQ(pdf.substr(stream + std::stoul(pdf.substr(length_at)), 9), "endstream");
  // 25 mm are 70.86614 points.
  EXPECT_NE(pdf.find("70.86614 70.86614 re"), std::string::npos);
}

TEST(BoardPage, ATallBoardTurnsThePage) {
  const std::string svg = board_svg(parse_board("chessboard:6x9:25mm"), parse_page("a4"));
  EXPECT_NE(svg.find("width=\"210.0000mm\" height=\"297.0000mm\""), std::string::npos);
}

TEST(BoardPage, RefusesWhatDoesNotFit) {
  EXPECT_EQ(complaint("chessboard:9x6:30mm", "a4"),
            "board chessboard:9x6:30mm: measures 300 x 210 mm and needs a page of 316 x 240 mm with its "
            "margins and "
            "ruler, not 297 x 210 mm; take a larger page (--page a3) or smaller squares");
  EXPECT_EQ(complaint("chessboard:9x6:30mm", "a3"), "");
  EXPECT_EQ(complaint("chessboard:9x6:30mm", "316x240mm"), "");
  EXPECT_NE(complaint("chessboard:2x2:10mm", "100x100mm").find("needs a page of 116 x"), std::string::npos)
      << "the ruler needs room, too";
  EXPECT_NE(complaint("chessboard:2x2:10mm", "a9").find("page \"a9\": must be a4"), std::string::npos);
  EXPECT_NE(complaint("chessboard:2x2:10mm", "10x10mm").find("must be"), std::string::npos);
  EXPECT_NE(complaint("chessboard:2x2:10mm", "300x200").find("must be"), std::string::npos);
}

TEST(BoardPage, CharucoHasItsMarkers) {
  if (!have_board_finder()) {
    EXPECT_NE(complaint("charuco:8x5:30mm:22mm:5X5_100", "a4").find("built without OpenCV"),
              std::string::npos);
    return;
  }
  for (const auto& [dictionary, cells] : {std::pair{"5X5_100", 7}, std::pair{"APRILTAG_36h11", 8}}) {
    const BoardSpec board = parse_board(std::string("charuco:8x5:30mm:22mm:") + dictionary);
    const std::string svg = board_svg(board, parse_page("a4"));
    // The black frame of a marker is one cell high and all of its cells wide, in one piece.
    char frame[60];
    std::snprintf(frame, sizeof frame, "h%.4fv%.4f", 22.0, 22.0 / cells);
    std::size_t frames = 0;
    for (std::size_t at = svg.find(frame); at != std::string::npos; at = svg.find(frame, at + 1)) ++frames;
    EXPECT_GE(frames, 2u * 20u) << dictionary;
  }
}

}  // namespace
}  // namespace glint
