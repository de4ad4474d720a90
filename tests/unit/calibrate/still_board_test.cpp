// SPDX-License-Identifier: MIT
// A board that lies on the floor of the simulated rig.
#include "host/calibrate/still_board.hpp"

#include <random>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/sim/rig.hpp"

namespace glint {
namespace {

using ::testing::HasSubstr;

class StillBoardTest : public ::testing::Test {
 protected:
  StillBoardTest() {
    samples_.target.kind = TargetKind::Board;
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 7; ++x) samples_.target.points_in_target.emplace_back(0.06 * x, 0.06 * y, 0.0);
    for (const CameraCalibration& c : rig_.cameras)
      samples_.cameras.push_back({c.name, c.width_px, c.height_px});
  }

  /// What the cameras from `first` on see of it at that tick.
  void see(std::uint64_t tick, const Pose& world_from_board, double sigma_px, std::size_t first = 0) {
    std::normal_distribution<double> noise(0.0, sigma_px);
    for (std::size_t c = first; c < rig_.cameras.size(); ++c) {
      const Camera camera(rig_.cameras[c]);
      for (std::uint32_t p = 0; p < samples_.target.points_in_target.size(); ++p) {
        const auto pixel = camera.project(world_from_board * samples_.target.points_in_target[p]);
        ASSERT_TRUE(pixel);
        samples_.sightings.push_back({tick, static_cast<std::uint32_t>(c), p,
                                      *pixel + Eigen::Vector2d(noise(random_), noise(random_))});
      }
    }
  }

  std::string complaint() const {
    try {
      place_still_board(samples_, rig_);
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  }

  const Calibration rig_ = sim_calibration({});
  /// Printed side up: the board's z points down.
  const Pose on_floor_{Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()) *
                                          Eigen::AngleAxisd(3.14159265358979, Eigen::Vector3d::UnitX())),
                       {0.2, -0.1, 0.005}};
  SampleSet samples_;
  std::mt19937 random_{5};
};

TEST_F(StillBoardTest, IsPlacedExactlyWithoutNoise) {
  see(0, on_floor_, 0.0);
  const StillBoard board = place_still_board(samples_, rig_);
  EXPECT_EQ(board.cameras, rig_.cameras.size());
  EXPECT_LT(board.rms_px, 1e-5);
  EXPECT_LT((board.world_from_board.translation - on_floor_.translation).norm(), 1e-7);
  EXPECT_LT(board.world_from_board.rotation.angularDistance(on_floor_.rotation), 1e-6);
}

TEST_F(StillBoardTest, NoiseAveragesOut) {
  for (std::uint64_t tick = 0; tick < 10; ++tick) see(tick, on_floor_, 0.2);
  const StillBoard board = place_still_board(samples_, rig_);
  EXPECT_LT(board.rms_px, 0.15) << "0.2 px on two axes, over ten ticks";
  EXPECT_LT((board.world_from_board.translation - on_floor_.translation).norm(), 5e-4);
  EXPECT_LT(board.world_from_board.rotation.angularDistance(on_floor_.rotation), 2e-3);
}

TEST_F(StillBoardTest, OneCameraWillDo) {
  see(0, on_floor_, 0.02, rig_.cameras.size() - 1);
  const StillBoard board = place_still_board(samples_, rig_);
  EXPECT_EQ(board.cameras, 1u);
  EXPECT_LT((board.world_from_board.translation - on_floor_.translation).norm(), 5e-3);
}

TEST_F(StillBoardTest, RefusesABoardThatMoves) {
  for (std::uint64_t tick = 0; tick < 10; ++tick) {
    Pose pose = on_floor_;
    pose.translation.x() += 0.002 * static_cast<double>(tick);
    see(tick, pose, 0.05);
  }
  EXPECT_THAT(complaint(), HasSubstr("the board moves, by "));
}

TEST_F(StillBoardTest, RefusesABoardOfAnotherSize) {
  see(0, on_floor_, 0.05);
  for (Eigen::Vector3d& p : samples_.target.points_in_target) p *= 1.2;
  EXPECT_THAT(complaint(), HasSubstr("does not fit the calibration"));
}

TEST_F(StillBoardTest, RefusesWhenNothingIsSeen) {
  EXPECT_THAT(complaint(), HasSubstr("no camera sees enough of the board"));
  samples_.cameras[0].name = "other";
  EXPECT_THAT(complaint(), HasSubstr("the calibration has no camera \"other\""));
}

}  // namespace
}  // namespace glint
