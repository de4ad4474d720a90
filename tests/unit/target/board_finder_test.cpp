// SPDX-License-Identifier: MIT
// Corners in simulated pictures against the truth; mirrored, inverted, turned and wrong boards.
#include "host/target/board_finder.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/sim/board_poses.hpp"
#include "host/sim/rig.hpp"
#include "tests/unit/target/printed.hpp"

namespace glint {
namespace {

struct Picture {
  std::uint32_t width_px = 0, height_px = 0;
  std::vector<std::uint8_t> pixels;
  GreyPicture view() const { return {pixels.data(), width_px, height_px, width_px}; }
};

CameraCalibration camera() { return sim_calibration({}).cameras[0]; }

Picture take(const BoardSpec& board, const Pose& pose, std::uint64_t seed = 1, const SimSensor& sensor = {}) {
  const CameraCalibration c = camera();
  Picture picture{c.width_px, c.height_px, std::vector<std::uint8_t>(std::size_t{c.width_px} * c.height_px)};
  sim::board_picture(c, pose, testing::printed(board), sensor, seed, picture.pixels.data(), c.width_px);
  return picture;
}

Eigen::Vector2d truth(const BoardSpec& board, const Pose& pose, std::uint32_t point) {
  CameraCalibration c = camera();
  c.world_from_camera = Pose{};
  return Camera(c).project(pose * board_target(board).points_in_target[point]).value();
}

/// Upright before the camera, its middle on the axis.
Pose facing(const BoardSpec& board, double distance_m, double roll_rad = 0.0) {
  const Eigen::Vector2d middle = board_pattern(board).squares.center();
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  return {roll, Eigen::Vector3d(0.0, 0.0, distance_m) - roll * Eigen::Vector3d(middle.x(), middle.y(), 0.0)};
}

class BoardFinderOf : public ::testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  }
  BoardSpec board = parse_board(GetParam());
};

TEST_P(BoardFinderOf, FindsCornersWithoutBias) {
  const auto finder = make_board_finder(board);
  const auto poses = sim::board_poses(camera(), board_pattern(board).squares, 40, 7);
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0.0, worst = 0.0;
  std::size_t corners = 0, views = 0;
  for (std::size_t n = 0; n < poses.size(); ++n) {
    const Picture picture = take(board, poses[n], n);
    const BoardView view = finder->find(picture.view());
    views += view.finding == BoardFinding::Found;
    EXPECT_FALSE(view.inverted);
    for (const BoardCorner& corner : view.corners) {
      const Eigen::Vector2d off = corner.pixel - truth(board, poses[n], corner.point);
      sum += off;
      squares += off.squaredNorm();
      worst = std::max(worst, off.norm());
      ++corners;
    }
  }
  const Eigen::Vector2d mean = sum / static_cast<double>(corners);
  const double rms = std::sqrt(squares / static_cast<double>(corners));
  std::printf("%s: %zu of %zu views, %.1f %% of corners, mean %.4f %.4f, rms %.4f, worst %.3f px\n",
              GetParam(), views, poses.size(),
              100.0 * static_cast<double>(corners) / static_cast<double>(poses.size() * board.corners()),
              mean.x(), mean.y(), rms, worst);
  EXPECT_GE(views, 38u);
  EXPECT_GT(corners, 95 * poses.size() * board.corners() / 100);
  EXPECT_LT(mean.cwiseAbs().maxCoeff(), 0.02) << "half a pixel would be a wrong convention";
  EXPECT_LT(rms, 0.1);
}

INSTANTIATE_TEST_SUITE_P(
    Boards, BoardFinderOf,
    ::testing::Values("chessboard:9x6:25mm", "chessboard:8x6:30mm", "charuco:8x5:40mm:30mm:5X5_100",
                      "charuco:5x4:54mm:40.5mm:4X4_1000:legacy", "charuco:8x5:40mm:30mm:APRILTAG_16h5",
                      "charuco:8x5:40mm:30mm:APRILTAG_25h9", "charuco:8x5:40mm:30mm:APRILTAG_36h10",
                      "charuco:8x5:30mm:22mm:APRILTAG_36h11"));

TEST(BoardFinder, KnowsWhichCornerIsWhichHoweverTheBoardIsTurned) {
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  for (const char* const text :
       {"chessboard:9x6:25mm", "charuco:8x5:40mm:30mm:5X5_100", "charuco:8x5:40mm:30mm:APRILTAG_16h5",
        "charuco:8x5:40mm:30mm:APRILTAG_36h11"}) {
    const BoardSpec board = parse_board(text);
    for (int turn = 0; turn < 8; ++turn) {
      const Pose pose = facing(board, 0.6, (turn + 0.1) * std::numbers::pi / 4.0);
      const Picture picture = take(board, pose);
      const BoardView view = make_board_finder(board)->find(picture.view());
      ASSERT_EQ(view.corners.size(), board.corners()) << text << ", turned by " << turn << " eighths";
      for (const BoardCorner& corner : view.corners)
        EXPECT_LT((corner.pixel - truth(board, pose, corner.point)).norm(), 0.5) << text << " " << turn;
    }
  }
}

TEST(BoardFinder, TellsMirroredInvertedAndOtherwiseArrangedBoards) {
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  const BoardSpec board = parse_board("charuco:6x4:50mm:37mm:4X4_100");
  const Pose pose = facing(board, 0.5, 0.3);
  const Picture upright = take(board, pose);
  const auto look = [&](const BoardSpec& as, const Picture& picture) {
    return make_board_finder(as)->find(picture.view());
  };
  Picture mirrored = upright, inverted = upright;
  for (std::uint32_t y = 0; y < mirrored.height_px; ++y) {
    const auto row =
        mirrored.pixels.begin() + static_cast<std::ptrdiff_t>(std::size_t{y} * mirrored.width_px);
    std::reverse(row, row + mirrored.width_px);
  }
  for (std::uint8_t& pixel : inverted.pixels) pixel = static_cast<std::uint8_t>(255 - pixel);

  EXPECT_EQ(look(board, upright).finding, BoardFinding::Found);
  EXPECT_EQ(look(board, mirrored).finding, BoardFinding::Mirrored);
  EXPECT_TRUE(look(board, mirrored).corners.empty());
  const BoardView white_on_black = look(board, inverted);
  EXPECT_EQ(white_on_black.finding, BoardFinding::Found);
  EXPECT_TRUE(white_on_black.inverted);
  EXPECT_EQ(white_on_black.corners.size(), board.corners());

  BoardSpec legacy = board;
  legacy.legacy = true;
  EXPECT_EQ(look(legacy, upright).finding, BoardFinding::OtherLayout);
  EXPECT_EQ(look(board, take(legacy, pose)).finding, BoardFinding::OtherLayout);
  EXPECT_EQ(look(parse_board("charuco:6x4:50mm:37mm:6X6_100"), upright).finding, BoardFinding::None);
  const Picture empty{1280, 800, std::vector<std::uint8_t>(1280u * 800u, 90)};
  EXPECT_EQ(look(board, empty).finding, BoardFinding::None);
  EXPECT_EQ(look(parse_board("chessboard:9x6:25mm"), empty).finding, BoardFinding::None);
}

TEST(BoardFinder, ExactDrawingsAreFoundExactly) {
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  for (const char* const text : {"chessboard:9x6:30mm", "charuco:8x5:60mm:42mm:5X5_100"}) {
    const BoardSpec board = parse_board(text);
    const BoardPattern pattern = board_pattern(board);
    // A millimetre is a pixel, and the picture begins 40 mm left of and above the squares.
    const Eigen::Vector2d first = pattern.squares.min() - Eigen::Vector2d::Constant(0.04);
    const Eigen::Vector2d size = 1e3 * (pattern.squares.sizes() + Eigen::Vector2d::Constant(0.08));
    Picture picture;
    picture.width_px = static_cast<std::uint32_t>(std::lround(size.x()));
    picture.height_px = static_cast<std::uint32_t>(std::lround(size.y()));
    for (std::uint32_t y = 0; y < picture.height_px; ++y) {
      for (std::uint32_t x = 0; x < picture.width_px; ++x) {
        const Eigen::Vector2d at = first + 1e-3 * Eigen::Vector2d(x + 0.5, y + 0.5);
        const bool black = std::any_of(pattern.black.begin(), pattern.black.end(),
                                       [&](const Eigen::AlignedBox2d& box) { return box.contains(at); });
        picture.pixels.push_back(black ? 0 : 255);
      }
    }
    const BoardView view = make_board_finder(board)->find(picture.view());
    EXPECT_EQ(view.corners.size(), board.corners()) << text;
    for (const BoardCorner& corner : view.corners) {
      const Eigen::Vector2d on_page = board_target(board).points_in_target[corner.point].head<2>();
      const Eigen::Vector2d expected = 1e3 * (on_page - first) - Eigen::Vector2d::Constant(0.5);
      EXPECT_LT((corner.pixel - expected).norm(), 0.01) << text << " corner " << corner.point;
    }
  }
}

TEST(BoardFinder, PartOfACharucoBoardWillDo) {
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  const BoardSpec board = parse_board("charuco:8x5:40mm:30mm:5X5_100");
  Pose pose = facing(board, 0.4);
  pose.translation.x() += 0.28;  // its right part is outside
  const BoardView view = make_board_finder(board)->find(take(board, pose).view());
  ASSERT_EQ(view.finding, BoardFinding::Found);
  EXPECT_GE(view.corners.size(), kFewestCorners);
  EXPECT_LT(view.corners.size(), board.corners());
  for (const BoardCorner& corner : view.corners)
    EXPECT_LT((corner.pixel - truth(board, pose, corner.point)).norm(), 0.5);
}

TEST(BoardFinder, SaysSoWhereThereIsNoOpenCV) {
  if (have_board_finder()) GTEST_SKIP() << "built with OpenCV";
  try {
    make_board_finder(parse_board("chessboard:9x6:25mm"));
    FAIL();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("built without OpenCV. Install it"), std::string::npos) << e.what();
  }
}

}  // namespace
}  // namespace glint
