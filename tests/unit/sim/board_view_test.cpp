// SPDX-License-Identifier: MIT
// The picture of a board against a slow one that looks through the lens backwards, pixel by pixel.
#include "host/sim/board_view.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "host/geometry/camera.hpp"
#include "host/sim/board_poses.hpp"
#include "host/sim/rig.hpp"

namespace glint::sim {
namespace {

CameraCalibration lens() {
  CameraCalibration camera = sim_calibration({}).cameras[0];
  camera.world_from_camera = Pose{};
  return camera;
}

PrintedBoard squares() {
  PrintedBoard board;
  board.sheet = {Eigen::Vector2d(-0.05, -0.05), Eigen::Vector2d(0.25, 0.2)};
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 4; ++x)
      if ((x + y) % 2 == 0)
        board.black.emplace_back(Eigen::Vector2d(0.05 * x, 0.05 * y),
                                 Eigen::Vector2d(0.05 * (x + 1), 0.05 * (y + 1)));
  return board;
}

Pose tilted() {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Eigen::Vector3d(0.6, 0.8, 0.0))), {-0.25, -0.18, 0.45}};
}

/// Mean of the board's grey over a pixel and the blur, by looking along many rays.
double looked_up(const Camera& camera, const Pose& camera_from_board, const PrintedBoard& board,
                 const SimSensor& sensor, const BoardLight& light, int x, int y) {
  constexpr int kRays = 8000;
  const Pose board_from_camera = camera_from_board.inverse();
  double sum = 0.0, weights = 0.0;
  const double reach = 4.0 * sensor.psf_sigma_px + 0.5;
  // Blur and aperture together, as one weight: a box of one pixel through a Gaussian.
  const auto weight = [&](double t) {
    const double s = sensor.psf_sigma_px * std::numbers::sqrt2;
    return std::erf((t + 0.5) / s) - std::erf((t - 0.5) / s);
  };
  for (int i = 0; i < kRays; ++i) {
    // Evenly spread, but in no rows that an edge could lie along (Roberts' R2 sequence).
    double whole = 0.0;
    const double dx = reach * (2.0 * std::modf(0.5 + 0.7548776662466927 * i, &whole) - 1.0),
                 dy = reach * (2.0 * std::modf(0.5 + 0.5698402909980532 * i, &whole) - 1.0);
    const auto ray = camera.undistort({x + dx, y + dy});
    const Eigen::Vector3d from = board_from_camera.translation,
                          along = board_from_camera.rotation * ray->homogeneous();
    const Eigen::Vector2d hit = (from - from.z() / along.z() * along).head<2>();
    double grey = light.room_grey;
    if (board.sheet.contains(hit)) grey = light.white_grey;
    for (const Eigen::AlignedBox2d& box : board.black)
      if (box.contains(hit)) grey = light.black_grey;
    const double w = weight(dx) * weight(dy);
    sum += w * grey;
    weights += w;
  }
  return sensor.black_level_grey + sum / weights;
}

TEST(BoardView, AgreesWithLookingAlongRays) {
  const CameraCalibration calibration = lens();
  const Camera camera(calibration);
  const PrintedBoard board = squares();
  const SimSensor sensor;
  const BoardLight light;
  const std::vector<float> image = board_image(calibration, tilted(), board, sensor);
  double worst = 0.0;
  int edges = 0;
  for (const Eigen::Vector2d& corner :
       {Eigen::Vector2d(0.05, 0.05), Eigen::Vector2d(0.15, 0.1), Eigen::Vector2d(0.0, 0.0),
        Eigen::Vector2d(-0.05, 0.1), Eigen::Vector2d(0.075, 0.05)}) {
    const Eigen::Vector2d middle =
        camera.project(tilted() * Eigen::Vector3d(corner.x(), corner.y(), 0.0)).value();
    for (int y = static_cast<int>(middle.y()) - 4; y <= static_cast<int>(middle.y()) + 4; ++y) {
      for (int x = static_cast<int>(middle.x()) - 4; x <= static_cast<int>(middle.x()) + 4; ++x) {
        const double drawn = static_cast<double>(
            image[static_cast<std::size_t>(y) * calibration.width_px + static_cast<std::size_t>(x)]);
        worst = std::max(worst, std::abs(drawn - looked_up(camera, tilted(), board, sensor, light, x, y)));
        edges += drawn > light.black_grey + 20.0 && drawn < light.white_grey - 10.0;
      }
    }
  }
  EXPECT_GT(edges, 50);
  EXPECT_LT(worst, 1.0) << "of " << light.white_grey - light.black_grey << " grey levels";
}

TEST(BoardView, NoiseIsThatOfTheSensor) {
  const CameraCalibration calibration = lens();
  const PrintedBoard board = squares();
  const std::vector<float> mean = board_image(calibration, tilted(), board, {});
  std::vector<std::uint8_t> picture(mean.size());
  board_picture(calibration, tilted(), board, {}, 3, picture.data(), calibration.width_px);
  double squares_of_room = 0.0;
  std::size_t pixels = 0;
  for (std::size_t i = 0; i < 200u * calibration.width_px; ++i) {
    if (std::abs(mean[i] - 38.0f) > 1e-3f) continue;
    const double off = picture[i] - static_cast<double>(mean[i]);
    squares_of_room += off * off;
    ++pixels;
  }
  ASSERT_GT(pixels, 10'000u);
  // Shot noise of 30 grey levels, read noise of 5 electrons, rounding.
  const double grey_per_electron = 247.0 / 6300.0;
  const double expected = 30.0 * grey_per_electron + std::pow(5.0 * grey_per_electron, 2) + 1.0 / 12.0;
  EXPECT_NEAR(squares_of_room / static_cast<double>(pixels) / expected, 1.0, 0.05);
  std::vector<std::uint8_t> again(mean.size());
  board_picture(calibration, tilted(), board, {}, 3, again.data(), calibration.width_px);
  EXPECT_EQ(picture, again);
}

TEST(BoardPoses, ShowTheWholeBoardEverywhereAndTilted) {
  const CameraCalibration camera = lens();
  const Eigen::AlignedBox2d area(Eigen::Vector2d(-0.025, -0.025), Eigen::Vector2d(0.225, 0.15));
  const auto poses = board_poses(camera, area, 30, 5);
  ASSERT_EQ(poses.size(), 30u);
  double most_tilt = 0.0, left = 1e9, right = -1e9, top = 1e9, bottom = -1e9;
  const Camera model(camera);
  for (const Pose& pose : poses) {
    EXPECT_TRUE(board_in_view(camera, pose, area, 4.0));
    const double tilt = std::acos((pose.rotation * Eigen::Vector3d::UnitZ()).z());
    most_tilt = std::max(most_tilt, tilt);
    EXPECT_LE(tilt, std::numbers::pi / 4.0 + 1e-9);
    for (const Eigen::Vector2d& corner : {area.min(), area.max()}) {
      const Eigen::Vector2d pixel =
          model.project(pose * Eigen::Vector3d(corner.x(), corner.y(), 0.0)).value();
      left = std::min(left, pixel.x());
      right = std::max(right, pixel.x());
      top = std::min(top, pixel.y());
      bottom = std::max(bottom, pixel.y());
    }
  }
  EXPECT_GT(most_tilt, 0.6);
  EXPECT_LT(left, 60.0);
  EXPECT_LT(top, 60.0);
  EXPECT_GT(right, 1220.0);
  EXPECT_GT(bottom, 740.0);
}

TEST(BoardView, KnowsWhatIsInView) {
  const Eigen::AlignedBox2d area(Eigen::Vector2d(0.0, 0.0), Eigen::Vector2d(0.2, 0.1));
  const Pose ahead{Eigen::Quaterniond::Identity(), {-0.1, -0.05, 0.5}};
  EXPECT_TRUE(board_in_view(lens(), ahead, area, 5.0));
  EXPECT_FALSE(board_in_view(lens(), {ahead.rotation, {0.3, 0.0, 0.5}}, area, 5.0)) << "off to the right";
  EXPECT_FALSE(board_in_view(lens(), {ahead.rotation, {-0.1, -0.05, -0.5}}, area, 5.0)) << "behind";
  const Eigen::Quaterniond half(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitY()));
  EXPECT_FALSE(board_in_view(lens(), {half, {0.1, -0.05, 0.5}}, area, 5.0)) << "its back";
}

}  // namespace
}  // namespace glint::sim
