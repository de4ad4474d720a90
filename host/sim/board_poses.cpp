// SPDX-License-Identifier: MIT
// Random poses, of which the one is taken that shows most that is new.
#include "host/sim/board_poses.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "host/base/error.hpp"
#include "host/sim/random.hpp"
#include "host/sim/sim_camera.hpp"

namespace glint::sim {
namespace {

constexpr std::size_t kColumns = 16, kRows = 10;  // what was seen, in cells of the image
constexpr std::size_t kPoints = 9;                // of the board along each side, to count cells with
constexpr int kCandidates = 60, kTries = 4000;
constexpr double kMargin_px = 4.0;

Pose random_pose(const CameraCalibration& camera, const Eigen::AlignedBox2d& area, Random& random) {
  constexpr double kTurn = std::numbers::pi / 4.0;
  const double direction = random.uniform(-std::numbers::pi, std::numbers::pi),
               tilt = kTurn * random.uniform(), roll = 0.5 * kTurn * random.uniform(-1.0, 1.0);
  const double share =
      random.uniform(0.25, 0.75);  // of the image's width that the board fills, unless tilted
  const double distance_m = area.sizes().x() * camera.fx_px / (share * camera.width_px);
  const Eigen::Vector2d pixel(random.uniform() * camera.width_px, random.uniform() * camera.height_px);
  const Eigen::Quaterniond rotation(
      Eigen::AngleAxisd(tilt, Eigen::Vector3d(std::cos(direction), std::sin(direction), 0.0)) *
      Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ()));
  // Near enough without the lens: the pose is random anyway.
  const Eigen::Vector3d middle((pixel.x() - camera.cx_px) / camera.fx_px * distance_m,
                               (pixel.y() - camera.cy_px) / camera.fy_px * distance_m, distance_m);
  const Eigen::Vector2d centre = area.center();
  return {rotation, middle - rotation * Eigen::Vector3d(centre.x(), centre.y(), 0.0)};
}

/// Which cells the board covers.
std::array<bool, kColumns * kRows> cells_of(const CameraCalibration& calibration, const Pose& pose,
                                            const Eigen::AlignedBox2d& area) {
  CameraCalibration origin = calibration;
  origin.world_from_camera = Pose{};
  const SimCamera camera(origin);
  std::array<bool, kColumns * kRows> cells{};
  for (std::size_t y = 0; y < kPoints; ++y) {
    for (std::size_t x = 0; x < kPoints; ++x) {
      const Eigen::Vector2d share(static_cast<double>(x) / (kPoints - 1),
                                  static_cast<double>(y) / (kPoints - 1));
      const Eigen::Vector2d p = area.min() + share.cwiseProduct(area.sizes());
      const Eigen::Vector2d pixel = camera.project(pose * Eigen::Vector3d(p.x(), p.y(), 0.0));
      const auto cell = [](double at, double size, std::size_t count) {
        return static_cast<std::size_t>(
            std::clamp(at / size * static_cast<double>(count), 0.0, static_cast<double>(count) - 1.0));
      };
      cells[cell(pixel.y(), calibration.height_px, kRows) * kColumns +
            cell(pixel.x(), calibration.width_px, kColumns)] = true;
    }
  }
  return cells;
}

}  // namespace

std::vector<Pose> board_poses(const CameraCalibration& camera, const Eigen::AlignedBox2d& area,
                              std::size_t count, std::uint64_t seed) {
  Random random(stream_seed(seed, Stream::BoardPose));
  std::vector<double> seen(kColumns * kRows, 0.0);
  std::vector<Pose> poses;
  for (std::size_t n = 0; n < count; ++n) {
    std::optional<Pose> best;
    double best_worth = -1.0;
    for (int tries = 0, candidates = 0; tries < kTries && candidates < kCandidates; ++tries) {
      const Pose pose = random_pose(camera, area, random);
      if (!board_in_view(camera, pose, area, kMargin_px)) continue;
      ++candidates;
      const auto cells = cells_of(camera, pose, area);
      double worth = 0.0;  // a cell counts the less the more often it was seen
      for (std::size_t i = 0; i < cells.size(); ++i)
        if (cells[i]) worth += 1.0 / (1.0 + seen[i]);
      // Without the root far views would never be taken, since near ones cover more.
      worth /= std::sqrt(static_cast<double>(std::count(cells.begin(), cells.end(), true)));
      if (worth > best_worth) {
        best = pose;
        best_worth = worth;
      }
    }
    if (!best) throw Error("the simulated board does not fit into the view of " + camera.name);
    const auto cells = cells_of(camera, *best, area);
    for (std::size_t i = 0; i < cells.size(); ++i) seen[i] += cells[i] ? 1.0 : 0.0;
    poses.push_back(*best);
  }
  return poses;
}

}  // namespace glint::sim
