// SPDX-License-Identifier: MIT
// One camera on the ceiling: points on the floor plane out of whole runs, against the truth.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/config/rig.hpp"
#include "host/geometry/camera.hpp"
#include "host/geometry/sphere_bias.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

using ::testing::HasSubstr;

constexpr double kMarkerHeight_m = 0.3, kRadius_m = 0.0063, kCentroidSd_px = 0.05, kRate_hz = 90.0;
constexpr int kTicks = 450, kMarkers = 6;

/// 2.5 m above a field of 1.5 m x 2.2 m, as a robot laboratory has it; looking down, 10 degrees askew.
Calibration ceiling() {
  CameraCalibration c;
  c.name = "ceiling";
  c.width_px = 1280;
  c.height_px = 800;
  c.fx_px = c.fy_px = 914.0;
  c.cx_px = 641.0;
  c.cy_px = 397.0;
  c.k1_k2_p1_p2_k3 = {-0.32, 0.12, 2e-4, -3e-4, -0.02};
  const Eigen::AngleAxisd down(std::numbers::pi, Eigen::Vector3d::UnitX());
  const Eigen::AngleAxisd askew(10.0 * std::numbers::pi / 180.0, Eigen::Vector3d(1.0, 0.5, 0.2).normalized());
  c.world_from_camera.rotation = Eigen::Quaterniond(askew * down).normalized();
  c.world_from_camera.translation = {0.1, -0.05, 2.5};
  Calibration calibration;
  calibration.made_at = "2026-01-01T00:00:00Z";
  calibration.made_from = "a test";
  calibration.cameras.push_back(c);
  return calibration;
}

/// Robots that drive in ellipses at up to 2 m/s.
Eigen::Vector3d marker_at(int marker, double time_s) {
  const double phase = 1.1 * marker, turn = (marker % 2 == 0 ? 1.0 : -1.0) * (1.0 + 0.15 * marker);
  const double size = 0.12 + 0.05 * marker;
  return {size * std::cos(turn * time_s + phase) + 0.05, 1.4 * size * std::sin(turn * time_s + phase),
          kMarkerHeight_m};
}

class PlaneTrack : public ::testing::Test {
 protected:
  PlaneTrack() {
    std::filesystem::create_directory(folder_.path() / "blobs");
    write_calibration(folder_.path() / "cal.toml", ceiling());
    write_rig(kMarkerHeight_m);
    const Camera camera(ceiling().cameras.front());
    std::mt19937_64 random(5);
    std::normal_distribution<double> noise(0.0, kCentroidSd_px);
    std::ofstream blobs(folder_.path() / "blobs" / "ceiling.csv");
    blobs << "tick,x_px,y_px\n";
    for (int tick = 0; tick < kTicks; ++tick) {
      for (int m = 0; m < kMarkers; ++m) {
        // The centre of a sphere's outline, through the lens.
        const Eigen::Vector3d ball = marker_at(m, tick / kRate_hz);
        Eigen::Vector3d in_camera = camera.in_camera(ball);
        in_camera.head<2>() *= sphere_bias_factor(kRadius_m, in_camera.z());
        const Pose& pose = camera.calibration().world_from_camera;
        const auto pixel = camera.project(pose * in_camera);
        if (!pixel || !camera.inside(*pixel, 2.0)) continue;
        blobs << tick << ',' << pixel->x() + noise(random) << ',' << pixel->y() + noise(random) << '\n';
      }
    }
  }

  void write_rig(double height_m) {
    std::ofstream rig(folder_.path() / "rig.toml");
    rig << "format = 1\nkind = \"rig\"\n[rig]\nname = \"floor\"\nrate_hz = 90\ncalibration = \"cal.toml\"\n"
        << "marker_radius_m = " << kRadius_m << "\n[match]\nplane_height_m = " << height_m << "\n";
  }

  Outcome track(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments{"track",
                                       "blobs:" + (folder_.path() / "blobs").string(),
                                       "--rig",
                                       (folder_.path() / "rig.toml").string(),
                                       "--force",
                                       "--output",
                                       "csv:" + (folder_.path() / "points.csv").string(),
                                       "--summary",
                                       (folder_.path() / "summary.json").string()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_glint(arguments);
  }

  struct Errors {
    double rms_mm = 0.0, worst_mm = 0.0;
    int points = 0;
    std::map<int, int> ids;  // by marker: the last one
    int switches = 0;
  };
  /// Each point against the nearest marker.
  Errors errors() {
    Errors result;
    std::ifstream file(folder_.path() / "points.csv");
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
      std::replace(line.begin(), line.end(), ',', ' ');
      std::istringstream row(line);
      int tick = 0, id = 0;
      long long time_ns = 0;
      Eigen::Vector3d point;
      row >> tick >> time_ns >> id >> point.x() >> point.y() >> point.z();
      int nearest = 0;
      double distance = 1e9;
      for (int m = 0; m < kMarkers; ++m) {
        const double d = (point - marker_at(m, tick / kRate_hz)).head<2>().norm();
        if (d < distance) distance = d, nearest = m;
      }
      result.rms_mm += 1e6 * distance * distance;
      result.worst_mm = std::max(result.worst_mm, 1e3 * distance);
      ++result.points;
      if (result.ids.contains(nearest) && result.ids[nearest] != id) ++result.switches;
      result.ids[nearest] = id;
    }
    result.rms_mm = std::sqrt(result.rms_mm / std::max(1, result.points));
    return result;
  }

  TempDir folder_;
};

TEST_F(PlaneTrack, MeasuresXAndYOfMarkersAtAKnownHeight) {
  const Outcome outcome = track();
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("z = 0.3 m"));
  const Errors right = errors();
  EXPECT_GT(right.points, kMarkers * kTicks * 97 / 100);
  EXPECT_LT(right.rms_mm, 0.25);
  EXPECT_LT(right.worst_mm, 1.2);
  EXPECT_EQ(right.switches, 0);
  std::ifstream file(folder_.path() / "summary.json");
  EXPECT_EQ(nlohmann::json::parse(file)["plane_height_m"], kMarkerHeight_m);

  // As if the markers were on the floor: what the height is worth.
  ASSERT_EQ(track({"--plane-height", "0"}).exit_code, 0);
  const Errors wrong = errors();
  EXPECT_GT(wrong.rms_mm, 100.0 * right.rms_mm);
  std::printf("rms %.3f mm, worst %.3f mm; with the height taken as 0: rms %.1f mm, worst %.1f mm\n",
              right.rms_mm, right.worst_mm, wrong.rms_mm, wrong.worst_mm);
}

TEST_F(PlaneTrack, RefusesWhatCannotWork) {
  write_rig(2.8);
  Outcome outcome = track();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("camera ceiling does not look at the plane z = 2.8 m"));

  Calibration level = ceiling();
  level.cameras[0].fx_px = level.cameras[0].fy_px = 20'000.0;
  level.cameras[0].k1_k2_p1_p2_k3 = {};
  level.cameras[0].world_from_camera.rotation =
      Eigen::Quaterniond(Eigen::AngleAxisd(-0.5 * std::numbers::pi, Eigen::Vector3d::UnitX()));
  write_calibration(folder_.path() / "cal.toml", level, true);
  write_rig(kMarkerHeight_m);
  outcome = track();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("only edge-on, at less than 5 degrees"));

  Calibration two = ceiling();
  two.cameras.push_back(two.cameras.front());
  two.cameras.back().name = "other";
  write_calibration(folder_.path() / "cal.toml", two, true);
  outcome = track();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("match.plane_height_m is for a rig of one camera"));
  EXPECT_THAT(outcome.err, HasSubstr("rig.toml:9:18"));

  write_calibration(folder_.path() / "cal.toml", ceiling(), true);
  std::ofstream(folder_.path() / "rig.toml")
      << "format = 1\nkind = \"rig\"\n[rig]\nname = \"floor\"\nrate_hz = 90\ncalibration = \"cal.toml\"\n";
  outcome = track();
  EXPECT_EQ(outcome.exit_code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("--plane-height"));
}

}  // namespace
}  // namespace glint::test
