// SPDX-License-Identifier: MIT
// Which views are kept, and what is said to be missing.
#include "host/calibrate/board_session.hpp"

#include <algorithm>

#include <gtest/gtest.h>

#include "host/sim/board_poses.hpp"
#include "host/sim/rig.hpp"
#include "host/target/board.hpp"

namespace glint {
namespace {

CameraCalibration lens() {
  CameraCalibration camera = sim_calibration({}).cameras[0];
  camera.world_from_camera = Pose{};
  camera.k1_k2_p1_p2_k3 = {};  // so that the guess of the lens is right
  return camera;
}

const BoardSpec& board() {
  static const BoardSpec spec = parse_board("chessboard:9x6:25mm");
  return spec;
}

BoardPoints view_of(const Pose& pose) {
  const Camera camera(lens());
  const Target target = board_target(board());
  BoardPoints view;
  for (std::uint32_t p = 0; p < target.points_in_target.size(); ++p) {
    view.points.push_back(p);
    view.pixels.push_back(camera.project(pose * target.points_in_target[p]).value());
  }
  return view;
}

Pose at(double x_m, double y_m, double z_m, double tilt_rad = 0.0,
        const Eigen::Vector3d& about = Eigen::Vector3d::UnitY()) {
  const Eigen::Quaterniond turn(Eigen::AngleAxisd(tilt_rad, about));
  return {turn, Eigen::Vector3d(x_m, y_m, z_m) - turn * Eigen::Vector3d(0.1, 0.0625, 0.0)};
}

bool says(const std::vector<std::string>& sentences, const std::string& words) {
  return std::any_of(sentences.begin(), sentences.end(),
                     [&](const std::string& s) { return s.find(words) != std::string::npos; });
}

TEST(BoardSession, KeepsOnlyWhatDiffers) {
  BoardSession session(board_target(board()), 1280, 800);
  EXPECT_TRUE(session.add(view_of(at(0, 0, 0.4))));
  EXPECT_FALSE(session.add(view_of(at(0, 0, 0.4))));
  EXPECT_FALSE(session.add(view_of(at(0.004, 0, 0.4)))) << "9 pixels";
  EXPECT_TRUE(session.add(view_of(at(0.04, 0, 0.4))));
  EXPECT_TRUE(session.add(view_of(at(0, 0, 0.4, 0.6))));
  EXPECT_FALSE(session.add(view_of(at(0.04, 0.001, 0.4))));
  EXPECT_EQ(session.views().size(), 3u);
}

TEST(BoardSession, SaysWhichTiltIsMissing) {
  BoardSession session(board_target(board()), 1280, 800);
  for (int n = 0; n < 6; ++n) session.add_always(view_of(at(-0.1 + 0.03 * n, 0.05, 0.3 + 0.05 * n)));
  EXPECT_TRUE(says(session.blocking(), "are within 0 degrees of one another"));
  for (const double tilt : {-0.5, 0.5}) session.add_always(view_of(at(0, 0, 0.4, tilt)));
  EXPECT_TRUE(session.blocking().empty());
  EXPECT_FALSE(says(session.missing(), "left and right side"));
  EXPECT_TRUE(says(session.missing(), "upper and lower edge"));
  for (const double tilt : {-0.5, 0.5})
    session.add_always(view_of(at(0, 0, 0.4, tilt, Eigen::Vector3d::UnitX())));
  EXPECT_FALSE(says(session.missing(), "upper and lower edge"));
}

TEST(BoardSession, SaysWhereTheBoardWasNot) {
  BoardSession session(board_target(board()), 1280, 800);
  for (int n = 0; n < 8; ++n) session.add_always(view_of(at(-0.2, -0.12, 0.7, 0.1 * n)));
  EXPECT_TRUE(says(session.missing(), "nothing yet in the bottom and the right of the image"))
      << ::testing::PrintToString(session.missing());
}

TEST(BoardSession, IsContentWithAGoodSession) {
  const CameraCalibration camera = lens();
  BoardSession session(board_target(board()), camera.width_px, camera.height_px);
  for (const Pose& pose : sim::board_poses(camera, board_pattern(board()).squares, 40, 1))
    session.add(view_of(pose));
  for (const std::string& sentence : session.missing()) ADD_FAILURE() << sentence;
}

}  // namespace
}  // namespace glint
