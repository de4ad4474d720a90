// SPDX-License-Identifier: MIT
// Places of real cameras from a printed board: four webcams without a trigger, and a stereo pair. Needs the
// shared recordings (GLINT_TEST_DATA).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "host/calibrate/evaluate.hpp"
#include "host/calibrate/extrinsics.hpp"
#include "host/calibrate/intrinsics.hpp"
#include "host/capture/image_file.hpp"
#include "host/config/import_calibration.hpp"
#include "host/geometry/triangulate.hpp"
#include "host/target/board_finder.hpp"
#include "tests/support/test_data.hpp"

namespace glint {
namespace {

void print(const ExtrinsicsResult& result) {
  for (const CameraQuality& camera : result.quality.cameras) {
    std::printf("%s: fit rms %.3f px, held out rms %.3f px, %llu outliers\n", camera.name.c_str(),
                camera.fit_px.rms, camera.held_out_px.rms, static_cast<unsigned long long>(camera.outliers));
  }
  for (const LengthQuality& length : result.quality.lengths)
    std::printf("%.3f m: mean %.5f, sd %.3f mm, rms %.3f mm (%llu)\n", length.true_m, length.mean_m,
                1e3 * length.sd_m, 1e3 * length.error_m.rms,
                static_cast<unsigned long long>(length.error_m.count));
  for (const std::string& note : result.notes) std::printf("note: %s\n", note.c_str());
  if (result.timing) {
    for (const CameraTiming& camera : result.timing->cameras)
      std::printf("delay %.2f +- %.2f ms, ", 1e3 * camera.delay_s, 1e3 * camera.delay_sd_s);
    std::printf("jitter %.2f +- %.2f ms\n", 1e3 * result.timing->jitter_s, 1e3 * result.timing->jitter_sd_s);
  }
  std::printf("all fit %.3f px\n", result.quality.fit_rms_px);
}

/// sync_index,cam_id,object_id,keypoint_id,img_loc_x,img_loc_y,obj_loc_x,obj_loc_y,obj_loc_z
SampleSet read_corners(const std::filesystem::path& file, const Calibration& rig) {
  SampleSet samples;
  samples.target.kind = TargetKind::Board;
  samples.target.name = "stored corners";
  samples.target.points_in_target.assign(12, Eigen::Vector3d::Zero());
  samples.rate_hz = 25.0;
  for (const CameraCalibration& c : rig.cameras) samples.cameras.push_back({c.name, c.width_px, c.height_px});
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::vector<double> row;
    for (std::string field; std::getline(fields, field, ',');) row.push_back(std::stod(field));
    const auto point = static_cast<std::uint32_t>(row.at(3));
    samples.target.points_in_target.at(point) = {row.at(6), row.at(7), row.at(8)};
    samples.sightings.push_back(
        {static_cast<std::uint64_t>(row[0]), static_cast<std::uint32_t>(row[1]), point, {row[4], row[5]}});
  }
  put_in_order(samples);
  return samples;
}

class Webcams : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto folder = test::test_data("caliscope-4cam-charuco-video");
    if (!folder) GTEST_SKIP() << "SKIPPED: no caliscope-4cam-charuco-video";
    stored_ = import_calibration({*folder / "post_optimization" / "camera_array.toml"}, {});
    samples_ = read_corners(
        *folder / "post_optimization" / "calibration" / "extrinsic" / "CHARUCO" / "xy_CHARUCO.csv", stored_);
  }
  Calibration stored_;
  SampleSet samples_;
};

TEST_F(Webcams, WithoutTriggerArePlacedAndFoundOut) {
  ExtrinsicsOptions options;
  options.hold_out = false;
  const ExtrinsicsResult result = solve_extrinsics(samples_, stored_.cameras, options);
  print(result);
  const CalibrationQuality all = evaluate(result.calibration, samples_, false);
  std::printf("with all sightings: %.3f px rms of %llu; the stored calibration: %.3f px\n", all.fit_rms_px,
              static_cast<unsigned long long>(all.sightings_used),
              evaluate(stored_, samples_, false).fit_rms_px);
  EXPECT_LE(result.quality.fit_rms_px, 1.56);
  EXPECT_LE(result.quality.outliers, 65u);  // 3 % of 2,175
  EXPECT_LE(all.fit_rms_px, evaluate(stored_, samples_, false).fit_rms_px + 0.001);
  EXPECT_THAT(result.notes, ::testing::Contains(::testing::HasSubstr("not synchronised")));
}

/// As the peer's adjustment: every corner of every tick is a point of its own, none is left out or counts
/// less.
TEST_F(Webcams, PlainBundleAdjustmentReachesThePeersFigure) {
  Bundle bundle;
  bundle.target = marker_target(0.0);
  for (const CameraCalibration& c : stored_.cameras)
    bundle.cameras.push_back({intrinsics_of(c), {}, c.world_from_camera.inverse(), false});
  const std::vector<Camera> cameras(stored_.cameras.begin(), stored_.cameras.end());
  for (const SampleTick& tick : ticks_of(samples_)) {
    for (std::uint32_t point = 0; point < 12; ++point) {
      std::vector<Observation> views;
      std::vector<BundleSighting> seen;
      for (const Sighting& s : tick.sightings) {
        const auto plane = cameras[s.camera].undistort(s.pixel);
        if (s.point != point || !plane) continue;
        views.push_back({&cameras[s.camera], *plane, Eigen::Matrix2d::Identity()});
        seen.push_back({s.camera, static_cast<std::uint32_t>(bundle.ticks.size()), 0, s.pixel});
      }
      const auto found = triangulate(views, {});
      if (!found) continue;
      bundle.ticks.push_back({{}, found->position_in_world});
      bundle.sightings.insert(bundle.sightings.end(), seen.begin(), seen.end());
    }
  }
  BundleOptions options;
  options.robust = false;
  options.scale_known = false;
  EXPECT_TRUE(adjust(bundle, options).converged);
  double squares = 0.0;
  for (const BundleSighting& s : bundle.sightings) {
    PredictedSighting predicted;
    const BundleCamera& camera = bundle.cameras[s.camera];
    ASSERT_TRUE(predict_sighting(
        camera.intrinsics.data(),
        camera.camera_from_world * Eigen::Vector3d(bundle.ticks[s.tick].points_in_world.col(0)), 0.0,
        predicted));
    squares += (predicted.pixel - s.pixel).squaredNorm();
  }
  const double rms_px = std::sqrt(squares / static_cast<double>(bundle.sightings.size()));
  std::printf("%zu sightings of %zu points: %.3f px rms\n", bundle.sightings.size(), bundle.ticks.size(),
              rms_px);
  EXPECT_GE(bundle.sightings.size(), 2170u);
  EXPECT_LE(rms_px, 1.56);
}

TEST(StereoPair, BaselineIsTheReferences) {
  const auto folder = test::test_data("opencv-stereo-chessboard");
  if (!folder || !test::is_intact(*folder, ".jpg", 711'386)) GTEST_SKIP();
  if (!have_board_finder()) GTEST_SKIP() << "SKIPPED: built without OpenCV";
  const BoardSpec board = parse_board("chessboard:9x6:25mm");
  const auto finder = make_board_finder(board);
  SampleSet samples;
  samples.target = board_target(board);
  for (const char* const name : {"left", "right"}) {
    const auto camera = static_cast<std::uint32_t>(samples.cameras.size());
    samples.cameras.push_back({name, 640, 480});
    for (unsigned n = 1; n <= 14; ++n) {
      const auto file = *folder / (name + std::string(n < 10 ? "0" : "") + std::to_string(n) + ".jpg");
      if (n == 10) continue;  // does not exist
      const GreyImage image = read_grey_image(file);
      const BoardView view =
          finder->find({image.pixels.data(), image.width_px, image.height_px, image.width_px});
      for (const BoardCorner& corner : view.corners)
        samples.sightings.push_back({n, camera, corner.point, corner.pixel});
    }
  }
  put_in_order(samples);
  std::vector<CameraCalibration> lenses;
  for (std::uint32_t camera : {0u, 1u}) lenses.push_back(calibrate_intrinsics(samples, camera, {}).camera);
  const ExtrinsicsResult result = solve_extrinsics(samples, lenses, {});
  print(result);
  const double baseline_m = result.calibration.cameras[1].world_from_camera.translation.norm();
  std::printf("baseline %.4f squares\n", baseline_m / board.square_m);
  EXPECT_NEAR(baseline_m / board.square_m, 3.344, 0.02);
}

}  // namespace
}  // namespace glint
