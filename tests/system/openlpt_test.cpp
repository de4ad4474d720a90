// SPDX-License-Identifier: MIT
// A peer's synthetic correspondence test: four cameras, thousands of tracers, lists shuffled. Needs
// GLINT_TEST_DATA.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "host/match/matcher.hpp"
#include "tests/support/test_data.hpp"

namespace glint {
namespace {

constexpr std::size_t kCameras = 4;

std::vector<double> numbers(std::string line) {
  std::replace(line.begin(), line.end(), ',', ' ');
  std::istringstream in(line);
  std::vector<double> values;
  for (double v = 0; in >> v;) values.push_back(v);
  return values;
}

/// "# Name:" lines, each followed by rows of numbers with commas; lengths in millimetres.
CameraCalibration read_camera(const std::filesystem::path& path) {
  std::ifstream in(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  const auto rows_after = [&](const std::string& head) {
    for (std::size_t k = 0; k < lines.size(); ++k)
      if (lines[k].rfind(head, 0) == 0) return &lines[k + 1];
    throw std::runtime_error(path.string() + ": no " + head);
  };
  const std::string* k = rows_after("# Camera Matrix");
  const std::string* r = rows_after("# Rotation Matrix");
  const auto size = numbers(*rows_after("# Image Size")), t = numbers(*rows_after("# Translation Vector"));
  CameraCalibration c;
  c.name = path.stem().string();
  c.height_px = static_cast<std::uint32_t>(size.at(0));
  c.width_px = static_cast<std::uint32_t>(size.at(1));
  c.fx_px = numbers(k[0]).at(0);
  c.cx_px = numbers(k[0]).at(2);
  c.fy_px = numbers(k[1]).at(1);  // negative here
  c.cy_px = numbers(k[1]).at(2);
  Eigen::Matrix3d rotation;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      rotation(row, column) = numbers(r[row]).at(static_cast<std::size_t>(column));
  // Written with six digits: the nearest rotation is what was meant.
  const Pose camera_from_world{Eigen::Quaterniond(rotation).normalized(),
                               1e-3 * Eigen::Vector3d(t[0], t[1], t[2])};
  c.world_from_camera = camera_from_world.inverse();
  return c;
}

std::vector<std::vector<double>> read_table(const std::filesystem::path& path, std::size_t rows) {
  std::ifstream in(path);
  std::vector<std::vector<double>> table;
  for (std::string line; table.size() < rows && std::getline(in, line);)
    if (auto row = numbers(line); row.size() >= 2) table.push_back(std::move(row));
  return table;
}

struct Outcome {
  std::size_t tracers = 0, right = 0, ghosts = 0;
  double seconds = 0.0;
  MatchCounters counters;
};

Outcome match_rows(const std::filesystem::path& folder, std::size_t rows, const MatchOptions& options) {
  Calibration calibration;
  std::vector<std::vector<shaders::BlobRecord>> blobs(kCameras);
  std::vector<std::vector<std::size_t>> tracer_of(kCameras);
  Outcome outcome;
  std::mt19937_64 random(20240501);
  for (std::size_t c = 0; c < kCameras; ++c) {
    const std::string number = std::to_string(c + 1);
    calibration.cameras.push_back(read_camera(folder / ("cam" + number + ".txt")));
    const auto table = read_table(folder / ("pt2d_list_cam" + number + ".csv"), rows);
    outcome.tracers = table.size();
    tracer_of[c].resize(table.size());
    std::iota(tracer_of[c].begin(), tracer_of[c].end(), std::size_t{0});
    std::shuffle(tracer_of[c].begin(), tracer_of[c].end(), random);
    const Camera camera(calibration.cameras.back());
    for (std::size_t tracer : tracer_of[c]) {
      shaders::BlobRecord blob{};
      blob.x_px = static_cast<float>(table[tracer][0]);
      blob.y_px = static_cast<float>(table[tracer][1]);
      const Eigen::Vector2d normalized = camera.undistort({table[tracer][0], table[tracer][1]}).value();
      blob.x_undist = static_cast<float>(normalized.x());
      blob.y_undist = static_cast<float>(normalized.y());
      blobs[c].push_back(blob);
    }
  }
  Matcher matcher(calibration, options);
  const std::vector<std::span<const shaders::BlobRecord>> spans(blobs.begin(), blobs.end());
  std::vector<Point> points;
  const auto start = std::chrono::steady_clock::now();
  matcher.match(spans, {}, points, outcome.counters);
  outcome.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  for (const Point& point : points) {
    bool right = point.views == kCameras;
    for (std::size_t c = 1; right && c < kCameras; ++c)
      right = tracer_of[c][static_cast<std::size_t>(point.blob_of_camera[c])] ==
              tracer_of[0][static_cast<std::size_t>(point.blob_of_camera[0])];
    ++(right ? outcome.right : outcome.ghosts);
  }
  std::printf(
      "%zu tracers, sigma %.3f gate %.2f px: %.3f %% right, %zu ghosts, %.2f s; %llu hypotheses, %llu cut; "
      "%llu "
      "components solved exactly, %llu not\n",
      outcome.tracers, options.sigma_px, options.gate_px,
      100.0 * static_cast<double>(outcome.right) / static_cast<double>(outcome.tracers), outcome.ghosts,
      outcome.seconds, static_cast<unsigned long long>(outcome.counters.hypotheses),
      static_cast<unsigned long long>(outcome.counters.hypotheses_cut),
      static_cast<unsigned long long>(outcome.counters.exact),
      static_cast<unsigned long long>(outcome.counters.inexact));
  return outcome;
}

/// The lists are good to 0.0004 px; the ranges are those of the measured volume.
MatchOptions options_for(double sigma_px, double gate_px) {
  MatchOptions options;
  options.sigma_px = sigma_px;
  options.gate_px = gate_px;
  options.min_range_m = 0.35;
  options.max_range_m = 0.50;
  return options;
}

class Openlpt : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto folder = test::test_data("openlpt-4cam-stereomatch");
    if (!folder) GTEST_SKIP();
    folder_ = *folder;
  }
  std::filesystem::path folder_;
};

TEST_F(Openlpt, TwoThousandTracersAreMatchedRight) {
  const Outcome o = match_rows(folder_, 2000, options_for(0.005, 0.05));
  ASSERT_EQ(o.tracers, 2000u);
  EXPECT_GE(o.right * 10'000, o.tracers * 9'995);
  EXPECT_EQ(o.ghosts, 0u);
  EXPECT_EQ(o.counters.hypotheses_cut, 0u);
}

TEST_F(Openlpt, TwoThousandTracersWithinThePeersTolerance) {
  // The peer's own test allows 1 px.
  const Outcome o = match_rows(folder_, 2000, options_for(0.1, 1.0));
  EXPECT_GE(o.right * 10'000, o.tracers * 9'995);
  EXPECT_EQ(o.ghosts, 0u);
}

TEST_F(Openlpt, AllTracersAtOnce) {
  const Outcome o = match_rows(folder_, 1'000'000, options_for(0.005, 0.05));
  ASSERT_EQ(o.tracers, 32926u);
  EXPECT_GE(o.right * 10'000, o.tracers * 9'990);
  EXPECT_LE(o.ghosts * 10'000, o.tracers);
  // Whatever was cut is counted; nothing needs to be here.
  EXPECT_EQ(o.counters.hypotheses_cut, 0u);
}

}  // namespace
}  // namespace glint
