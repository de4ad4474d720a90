// SPDX-License-Identifier: MIT
// `glint calibrate ground` with an L-frame or a board that lies on the floor before the simulated cameras.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <numbers>

#include "host/capture/image_file.hpp"
#include "host/config/rig.hpp"
#include "host/sim/board_view.hpp"
#include "host/sim/rig.hpp"
#include "host/target/board.hpp"
#include "host/target/board_finder.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

TEST(CalibrateGround, AnLFramePutsTheWorldOnTheFloor) {
  const TempDir folder;
  const Calibration rig = sim_calibration({});
  // The frame's world in the rig's: somewhere, turned by 40 degrees, its markers' centres 12 mm above the
  // floor.
  const Pose rig_from_floor{
      Eigen::Quaterniond(Eigen::AngleAxisd(40.0 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ())),
      {0.3, -0.2, 0.0}};
  const std::vector<Eigen::Vector3d> markers{
      {0.0, 0.0, 0.012}, {0.2, 0.0, 0.012}, {0.5, 0.0, 0.012}, {0.0, 0.3, 0.012}};
  for (const CameraCalibration& c : rig.cameras) {
    const Camera camera(c);
    std::string csv = "tick,x_px,y_px\n";
    for (int tick = 0; tick < 60; ++tick) {
      for (const Eigen::Vector3d& marker : markers) {
        const Eigen::Vector2d pixel = *camera.project(rig_from_floor * marker);
        char row[64];
        std::snprintf(row, sizeof row, "%d,%.3f,%.3f\n", tick, pixel.x(), pixel.y());
        csv += row;
      }
    }
    folder.write("blobs/" + c.name + ".csv", csv);
  }
  // As extrinsics leave it: the world is the first camera's frame.
  Calibration before = rig;
  for (CameraCalibration& c : before.cameras)
    c.world_from_camera = rig.cameras[0].world_from_camera.inverse() * c.world_from_camera;
  const std::string old_file = folder.path() / "old.toml", new_file = folder.path() / "new.toml";
  write_calibration(old_file, before);
  const Outcome outcome =
      run_glint({"calibrate", "ground", "blobs:" + (folder.path() / "blobs").string(), "--rig", old_file,
                 "--l-frame", "0.2,0.5:0.3", "--above-floor", "0.012", "--output", new_file});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const Calibration after = read_calibration(new_file);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Pose wanted = rig_from_floor.inverse() * rig.cameras[c].world_from_camera;
    EXPECT_LT((after.cameras[c].world_from_camera.translation - wanted.translation).norm(), 1e-3)
        << outcome.out;
    EXPECT_LT(after.cameras[c].world_from_camera.rotation.angularDistance(wanted.rotation), 1e-3);
  }

  const std::string turned_file = folder.path() / "turned.toml";
  const Outcome turned = run_glint({"calibrate", "ground", "--rig", new_file, "--rotate", "90", "--shift",
                                    "1,0,0", "--scale", "1:2", "--output", turned_file});
  ASSERT_EQ(turned.exit_code, 0) << turned.err;
  const Eigen::Vector3d was = after.cameras[0].world_from_camera.translation;
  const Eigen::Vector3d is = read_calibration(turned_file).cameras[0].world_from_camera.translation;
  EXPECT_LT((is - Eigen::Vector3d(1.0 - 2.0 * was.y(), 2.0 * was.x(), 2.0 * was.z())).norm(), 1e-9);
}

/// What the rig's cameras see of the board, and where it is in the rig's world, picture by picture.
class BoardPictures {
 public:
  BoardPictures(const BoardSpec& board, const Calibration& rig) : rig_(rig) {
    const BoardPattern pattern = board_pattern(board);
    const Eigen::Vector2d margin = Eigen::Vector2d::Constant(0.5 * board.square_m);
    printed_ = {{pattern.squares.min() - margin, pattern.squares.max() + margin}, pattern.black};
  }

  void write(const std::filesystem::path& folder, const std::vector<Pose>& rig_from_board) const {
    for (const CameraCalibration& c : rig_.cameras) {
      std::filesystem::create_directories(folder / c.name);
      std::vector<std::uint8_t> pixels(std::size_t{c.width_px} * c.height_px);
      for (std::size_t i = 0; i < rig_from_board.size(); ++i) {
        const Pose camera_from_board = c.world_from_camera.inverse() * rig_from_board[i];
        ASSERT_TRUE(sim::board_in_view(c, camera_from_board, printed_.sheet, 2.0)) << c.name;
        sim::board_picture(c, camera_from_board, printed_, {}, i, pixels.data(), c.width_px);
        write_pgm(folder / c.name / (std::to_string(i) + ".pgm"),
                  {pixels.data(), c.width_px, c.height_px, c.width_px});
      }
    }
  }

 private:
  const Calibration& rig_;
  sim::PrintedBoard printed_;
};

TEST(CalibrateGround, ABoardPutsTheWorldOnTheFloor) {
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  const std::string words = "charuco:6x5:160mm:120mm:4X4_50";
  const BoardSpec board = parse_board(words);
  const TempDir folder;
  const Calibration rig = sim_calibration({});
  // Printed side up and 5 mm thick: the board's z points down, its y against that of the floor.
  const Pose rig_from_floor{
      Eigen::Quaterniond(Eigen::AngleAxisd(40.0 * std::numbers::pi / 180.0, Eigen::Vector3d::UnitZ())),
      {-0.3, 0.2, 0.0}};
  const Pose floor_from_board{
      Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX())), {0.0, 0.0, 0.005}};
  const Pose lies = rig_from_floor * floor_from_board;
  const BoardPictures pictures(board, rig);
  pictures.write(folder.path() / "still", {lies, lies, lies});
  const std::string old_file = folder.path() / "old.toml", new_file = folder.path() / "new.toml";
  Calibration before = rig;
  for (CameraCalibration& c : before.cameras)
    c.world_from_camera = rig.cameras[0].world_from_camera.inverse() * c.world_from_camera;
  write_calibration(old_file, before);
  const auto place = [&](const std::string& source, const std::string& spec) {
    return run_glint({"calibrate", "ground", "images:" + (folder.path() / source).string(), "--rig", old_file,
                      "--board", spec, "--above-floor", "0.005", "--output", new_file});
  };
  const Outcome outcome = place("still", words);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, ::testing::HasSubstr("the board, seen by 4 cameras, fits to 0.")) << outcome.err;
  const Calibration after = read_calibration(new_file);
  for (std::size_t c = 0; c < rig.cameras.size(); ++c) {
    const Pose wanted = rig_from_floor.inverse() * rig.cameras[c].world_from_camera;
    EXPECT_LT((after.cameras[c].world_from_camera.translation - wanted.translation).norm(), 2e-3)
        << outcome.out << outcome.err;
    EXPECT_LT(after.cameras[c].world_from_camera.rotation.angularDistance(wanted.rotation), 1e-3);
  }

  Pose moved = lies;
  moved.translation.x() += 0.02;
  pictures.write(folder.path() / "moved", {lies, moved});
  const Outcome refused = place("moved", words);
  EXPECT_NE(refused.exit_code, 0);
  EXPECT_THAT(refused.err, ::testing::HasSubstr("the board moves, by "));
  EXPECT_THAT(place("still", "chessboard:5x5:160mm").err,
              ::testing::HasSubstr("looks the same after half a turn"));
}

}  // namespace
}  // namespace glint::test
