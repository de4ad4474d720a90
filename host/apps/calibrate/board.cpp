// SPDX-License-Identifier: MIT
// `glint calibrate board`: a board to print.
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string>

#include "host/apps/calibrate/commands.hpp"
#include "host/base/error.hpp"
#include "host/files/text_file.hpp"
#include "host/target/board_page.hpp"

namespace glint::apps {
namespace {

struct BoardArguments {
  std::string board, output, page = "a4";
  bool force = false;
};

void run(const BoardArguments& a) {
  const BoardSpec board = parse_board(a.board);
  const PageSize page = parse_page(a.page);
  const std::string kind = std::filesystem::path(a.output).extension().string();
  if (kind != ".svg" && kind != ".pdf")
    throw UsageError("--output " + a.output + ": must end in .pdf or .svg, which says what is written");
  write_text_file(a.output, kind == ".svg" ? board_svg(board, page) : board_pdf(board, page), a.force);
  std::printf(
      "wrote %s: %u x %u squares of %g mm\n"
      "Print it at 100 %% (\"actual size\"), check that its line measures 100 mm, and glue it to something "
      "flat and stiff.\n"
      "Then: glint calibrate intrinsics SOURCE --board %s\n",
      a.output.c_str(), board.squares_across, board.squares_down, 1e3 * board.square_m,
      to_text(board).c_str());
  if (!board.orientation_known()) {
    std::printf(
        "Half turned this board looks the same: good for intrinsics, but cameras cannot agree which corner "
        "is which. "
        "Take an odd number of inner corners one way and an even one the other to use it for extrinsics, "
        "too.\n");
  }
}

}  // namespace

void add_calibrate_board(CLI::App& calibrate) {
  CLI::App* command =
      calibrate.add_subcommand("board", "Write a printable chessboard or ChArUco board at true scale");
  const auto a = std::make_shared<BoardArguments>();
  command
      ->add_option(
          "BOARD", a->board,
          "chessboard:9x6:25mm (inner corners, square) or charuco:8x5:30mm:22mm:5X5_100 (squares, square, "
          "marker, dictionary)")
      ->required();
  command->add_option("-o,--output", a->output, "FILE.pdf or FILE.svg")->required();
  command->add_option("--page", a->page, "a4, a3, a2, a1, a0, letter, tabloid or WIDTHxHEIGHTmm")
      ->capture_default_str();
  command->add_flag("--force", a->force, "replace an existing file");
  command->callback([a] { run(*a); });
}

}  // namespace glint::apps
