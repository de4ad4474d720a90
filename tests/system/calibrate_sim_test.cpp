// SPDX-License-Identifier: MIT
// A whole calibration of the simulated rig as a student does it, against the truth: intrinsics from a printed
// board, extrinsics from a minute of wand, then a rod of known length tracked with the result.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <sstream>

#include <Eigen/Geometry>

#include "host/calibrate/expected_error.hpp"
#include "host/calibrate/extrinsics.hpp"
#include "host/calibrate/ground.hpp"
#include "host/config/rig.hpp"
#include "host/sim/rig.hpp"
#include "host/sim/scene.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

constexpr double kRod_m = 0.589;

/// truth_from_world by the cameras' positions; scale is not touched.
Pose alignment(const Calibration& found, const Calibration& truth) {
  const auto count = static_cast<Eigen::Index>(found.cameras.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index c = 0; c < count; ++c) {
    from.col(c) = found.cameras[static_cast<std::size_t>(c)].world_from_camera.translation;
    to.col(c) = truth.cameras[static_cast<std::size_t>(c)].world_from_camera.translation;
  }
  const Eigen::Matrix4d t = Eigen::umeyama(from, to, false);
  return {Eigen::Quaterniond(Eigen::Matrix3d(t.topLeftCorner<3, 3>())), t.topRightCorner<3, 1>()};
}

struct Tracked {
  std::uint64_t tick;
  Eigen::Vector3d position_in_world;
};

std::vector<Tracked> read_tracks(const std::filesystem::path& csv) {
  std::ifstream in(csv);
  std::string line;
  std::getline(in, line);
  std::vector<std::string> names;
  std::istringstream header(line);
  for (std::string name; std::getline(header, name, ',');) names.push_back(name);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  std::vector<Tracked> tracks;
  while (std::getline(in, line)) {
    std::vector<std::string> fields;
    std::istringstream row(line);
    for (std::string field; std::getline(row, field, ',');) fields.push_back(field);
    tracks.push_back({std::stoull(fields.at(column("tick"))),
                      {std::stod(fields.at(column("x_m"))), std::stod(fields.at(column("y_m"))),
                       std::stod(fields.at(column("z_m")))}});
  }
  return tracks;
}

/// The expected error of a point against what the tracked rod is really off by, square metre by square metre.
void compare_expected_error(const std::filesystem::path& samples, const std::filesystem::path& lenses,
                            const Calibration& truth, const Pose& truth_from_world,
                            const std::map<std::uint64_t, std::vector<Eigen::Vector3d>>& by_tick) {
  ExtrinsicsOptions options;
  options.refine_intrinsics = true;
  ExtrinsicsResult result =
      solve_extrinsics(read_samples(samples), read_calibration(lenses).cameras, options);
  const Pose into_truth = alignment(result.calibration, truth);
  transform(result.calibration, into_truth);
  transform(result.uncertainty, result.calibration, into_truth);
  const ExpectedError expected(result.calibration, result.uncertainty, SimOptions{}.marker_radius_m);

  SimOptions waved;
  waved.motion = SimMotion::Wand;
  waved.wand_m = {0.0, kRod_m};
  waved.markers = 2;
  const Scene scene(waved);
  struct Cell {
    double found_m2 = 0.0, expected_m2 = 0.0;
    std::uint64_t count = 0;
  };
  std::map<std::pair<int, int>, Cell> cells;
  for (const auto& [tick, points] : by_tick) {
    for (const Eigen::Vector3d& point : points) {
      const Eigen::Vector3d placed = truth_from_world * point;
      Eigen::Vector3d is = scene.marker(0, scene.mid_exposure_s(tick)).position_in_world;
      const Eigen::Vector3d other = scene.marker(1, scene.mid_exposure_s(tick)).position_in_world;
      if ((other - placed).norm() < (is - placed).norm()) is = other;
      const auto error = expected.at(is);
      if (!error) continue;
      Cell& cell = cells[{static_cast<int>(std::floor(is.x())), static_cast<int>(std::floor(is.y()))}];
      cell.found_m2 += (placed - is).squaredNorm(), cell.expected_m2 += error->covariance_m2().trace(),
          ++cell.count;
    }
  }
  std::size_t compared = 0;
  for (const auto& [place, cell] : cells) {
    if (cell.count < 100) continue;
    const double ratio = std::sqrt(cell.expected_m2 / cell.found_m2);
    std::printf("x %d to %d, y %d to %d m: expected %.4f mm, found %.4f mm rms, ratio %.2f (%llu)\n",
                place.first, place.first + 1, place.second, place.second + 1,
                1e3 * std::sqrt(cell.expected_m2 / static_cast<double>(cell.count)),
                1e3 * std::sqrt(cell.found_m2 / static_cast<double>(cell.count)), ratio,
                static_cast<unsigned long long>(cell.count));
    EXPECT_GT(ratio, 1.0 / 1.5);
    // Expected of blobs' centroids: the tracker, which looks at pixels and knows how markers move, does
    // better.
    EXPECT_LT(ratio, 2.0);
    ++compared;
  }
  EXPECT_GE(compared, 4u);
}

TEST(CalibrateSim, WandAfterBoardReachesTheTruth) {
  const TempDir folder;
  const std::string lenses = folder.path() / "lenses.toml", output = folder.path() / "rig.toml",
                    csv = folder.path() / "rod.csv", report = folder.path() / "rig.html",
                    json = folder.path() / "rig.json";
  const Calibration truth = sim_calibration({});
  const Outcome board = run_glint({"calibrate", "intrinsics", "sim", "--board",
                                   "charuco:8x5:30mm:22mm:5X5_100", "--k3", "--quiet", "--output", lenses});
  if (board.err.find("without OpenCV") != std::string::npos) GTEST_SKIP() << "SKIPPED: " << board.err;
  ASSERT_EQ(board.exit_code, 0) << board.err;
  const Outcome wand =
      run_glint({"calibrate", "extrinsics", "sim", "--rig", lenses, "--wand", "0,0.13,0.39", "--output",
                 output, "--refine-intrinsics", "--report", report, "--json", json, "--quiet"});
  ASSERT_EQ(wand.exit_code, 0) << wand.err;
  std::printf("%s%s", board.out.c_str(), wand.out.c_str());

  const Calibration found = read_calibration(output);
  const Pose truth_from_world = alignment(found, truth);
  for (std::size_t c = 0; c < truth.cameras.size(); ++c) {
    const Pose aligned = truth_from_world * found.cameras[c].world_from_camera;
    const double position_m = (aligned.translation - truth.cameras[c].world_from_camera.translation).norm();
    const double angle_deg = aligned.rotation.angularDistance(truth.cameras[c].world_from_camera.rotation) *
                             180.0 / std::numbers::pi;
    std::printf("%s: position off by %.3f mm, orientation by %.4f degrees, focal length by %.3f px\n",
                found.cameras[c].name.c_str(), 1e3 * position_m, angle_deg,
                found.cameras[c].fx_px - truth.cameras[c].fx_px);
    EXPECT_LE(position_m, 0.5e-3);
    EXPECT_LE(angle_deg, 0.01);
  }

  const Outcome rod = run_glint({"track", "sim", "--wave", "0,0.589", "--seconds", "60", "--pace", "fast",
                                 "--rig", output, "--output", "csv:" + csv});
  ASSERT_EQ(rod.exit_code, 0) << rod.err;
  std::map<std::uint64_t, std::vector<Eigen::Vector3d>> by_tick;
  for (const Tracked& point : read_tracks(csv)) by_tick[point.tick].push_back(point.position_in_world);
  double squares = 0.0, worst = 0.0;
  std::uint64_t pairs = 0;
  for (const auto& [tick, points] : by_tick) {
    if (points.size() != 2) continue;
    const double error_m = (points[1] - points[0]).norm() - kRod_m;
    squares += error_m * error_m, worst = std::max(worst, std::abs(error_m)), ++pairs;
  }
  const double rms_m = std::sqrt(squares / static_cast<double>(pairs));
  std::printf("rod of 589 mm: %llu pairs, error %.4f mm rms, %.3f mm at most\n",
              static_cast<unsigned long long>(pairs), 1e3 * rms_m, 1e3 * worst);
  compare_expected_error(folder.path() / "rig.samples.jsonl", lenses, truth, truth_from_world, by_tick);
  EXPECT_GT(pairs, 4500u);
  EXPECT_LE(rms_m, 0.08e-3);
}

}  // namespace
}  // namespace glint::test
