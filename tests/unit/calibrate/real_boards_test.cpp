// SPDX-License-Identifier: MIT
// Boards in real recordings: corners against those that another tool stored, a board seen from behind.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/calibrate/intrinsics.hpp"
#include "host/capture/image_file.hpp"
#include "host/capture/image_source.hpp"
#include "host/target/board_finder.hpp"
#include "tests/support/test_data.hpp"

namespace glint {
namespace {

/// All frames of a source, one after the other.
template <typename Visit>
void for_each_frame(FrameSource& source, Visit&& visit) {
  std::vector<FrameSize> sizes;
  for (const SourceCamera& camera : source.cameras()) sizes.push_back(camera.size);
  FramePool pool(sizes, 2);
  FrameSet set;
  while (source.read(pool, set) == ReadStatus::Ok) {
    for (std::uint32_t c = 0; c < sizes.size(); ++c) {
      if (!set.frames[c]) continue;
      const gpu::ImageView image = set.frames[c]->image();
      visit(c, number(set.trigger),
            GreyPicture{image.pixels, image.width_px, image.height_px, image.stride_bytes});
    }
  }
}

double quantile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto at = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

using StoredCorners = std::map<std::pair<std::uint32_t, std::uint64_t>, std::vector<Eigen::Vector2d>>;

/// caliscope's table, by camera and frame.
StoredCorners read_stored(const std::filesystem::path& file) {
  StoredCorners stored;
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  while (std::getline(in, line)) {
    std::istringstream fields(line);
    std::string field;
    std::vector<std::string> row;
    while (std::getline(fields, field, ',')) row.push_back(field);
    stored[{static_cast<std::uint32_t>(std::stoul(row[1])), std::stoull(row[2])}].emplace_back(
        std::stod(row[6]), std::stod(row[7]));
  }
  return stored;
}

SampleSet stereo_samples(const std::filesystem::path& folder, const BoardFinderOptions& options) {
  const BoardSpec board = parse_board("chessboard:9x6:25mm");
  const auto finder = make_board_finder(board, options);
  SampleSet samples;
  samples.target = board_target(board);
  for (const char* const name : {"left", "right"}) {
    const auto camera = static_cast<std::uint32_t>(samples.cameras.size());
    samples.cameras.push_back({name, 640, 480});
    for (unsigned n = 1; n <= 14; ++n) {
      const auto file = folder / (name + std::string(n < 10 ? "0" : "") + std::to_string(n) + ".jpg");
      if (!std::filesystem::exists(file)) continue;  // there is no 10
      const GreyImage image = read_grey_image(file);
      const BoardView view =
          finder->find({image.pixels.data(), image.width_px, image.height_px, image.width_px});
      EXPECT_EQ(view.corners.size(), 54u) << file;
      for (const BoardCorner& corner : view.corners)
        samples.sightings.push_back({n, camera, corner.point, corner.pixel});
    }
  }
  put_in_order(samples);
  return samples;
}

void print(const IntrinsicsResult& result) {
  const CameraCalibration& c = result.camera;
  std::printf(
      "%s: fx %.2f fy %.2f cx %.2f cy %.2f sd %.2f %.2f %.2f %.2f, k1 %.4f k2 %.4f p1 %.4f p2 %.4f k3 %.4f, "
      "rms %.4f held out %.4f px, %s\n",
      c.name.c_str(), c.fx_px, c.fy_px, c.cx_px, c.cy_px, c.intrinsics_sd[0], c.intrinsics_sd[1],
      c.intrinsics_sd[2], c.intrinsics_sd[3], c.k1_k2_p1_p2_k3[0], c.k1_k2_p1_p2_k3[1], c.k1_k2_p1_p2_k3[2],
      c.k1_k2_p1_p2_k3[3], c.k1_k2_p1_p2_k3[4], result.rms_px, result.held_out_rms_px, result.rule.c_str());
}

void expect_figures(const IntrinsicsResult& result, const std::array<double, 4>& fx_fy_cx_cy, double rms_px) {
  const CameraCalibration& c = result.camera;
  const std::array<double, 4> found{c.fx_px, c.fy_px, c.cx_px, c.cy_px};
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_NEAR(found[i], fx_fy_cx_cy[i], 1.5) << c.name << " parameter " << i;
  EXPECT_NEAR(result.rms_px, rms_px, 0.05 * rms_px) << c.name;
  print(result);
}

TEST(RealBoards, ChessboardPicturesGiveTheReferenceLenses) {
  const auto data = test::test_data("opencv-stereo-chessboard");
  if (!data || !test::is_intact(*data, ".jpg", 711'386)) GTEST_SKIP();
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  // The reference: OpenCV's calibrateCamera, k3 estimated, with corners from windows of 23 pixels.
  const SampleSet samples = stereo_samples(*data, {11});
  ASSERT_EQ(samples.sightings.size(), 2u * 13u * 54u);
  const IntrinsicsOptions as_opencv{.k3 = true, .robust = false};
  expect_figures(calibrate_intrinsics(samples, 0, as_opencv), {536.07, 536.02, 342.37, 235.54}, 0.4087);
  expect_figures(calibrate_intrinsics(samples, 1, as_opencv), {542.35, 541.61, 328.32, 246.95}, 0.4586);
  EXPECT_NEAR(calibrate_intrinsics(samples, 0, {.robust = false}).rms_px, 0.4089, 0.001);
  EXPECT_NEAR(calibrate_intrinsics(samples, 1, {.robust = false}).rms_px, 0.4587, 0.001);
}

TEST(RealBoards, ChessboardPicturesAreExplainedTwiceAsWellByGlintsOwnWindowsAndLoss) {
  const auto data = test::test_data("opencv-stereo-chessboard");
  if (!data || !test::is_intact(*data, ".jpg", 711'386)) GTEST_SKIP();
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  const SampleSet samples = stereo_samples(*data, {});
  for (std::uint32_t camera : {0u, 1u}) {
    const IntrinsicsResult result = calibrate_intrinsics(samples, camera, {});
    print(result);
    EXPECT_LT(result.rms_px, 0.25);
    EXPECT_LT(result.held_out_rms_px, 0.25);
    EXPECT_LE(
        std::count_if(result.views.begin(), result.views.end(), [](const auto& v) { return v.outlier; }), 1);
  }
}

TEST(RealBoards, CornersAgreeWithTheStoredOnesAndAMirroredBoardIsSaidToBeOne) {
  const auto data = test::test_data("caliscope-4cam-charuco-video");
  if (!data || !test::is_intact(*data / "prerecorded_calibration", ".mp4", 6'445'224)) GTEST_SKIP();
  if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  const auto folder = *data / "prerecorded_calibration/calibration/intrinsic";
  const StoredCorners stored = read_stored(folder / "CHARUCO/xy_CHARUCO.csv");
  const BoardSpec board = parse_board("charuco:4x5:54mm:40.5mm:4X4_1000");
  const auto source = open_image_source(folder.string(), {});
  ASSERT_EQ(source->cameras().size(), 4u);
  std::array<std::unique_ptr<BoardFinder>, 4> finders;
  for (auto& finder : finders) finder = make_board_finder(board);
  std::array<std::uint64_t, 4> corners{}, mirrored{}, found{}, upright{};
  std::array<std::vector<double>, 4> differences;
  std::vector<double> off_x, off_y;  // of the camera whose stored corners are good (see below)
  for_each_frame(*source, [&](std::uint32_t camera, std::uint64_t frame, const GreyPicture& picture) {
    const BoardView view = finders[camera]->find(picture);
    found[camera] += view.finding == BoardFinding::Found;
    mirrored[camera] += view.finding == BoardFinding::Mirrored;
    upright[camera] += view.finding == BoardFinding::Found && !view.inverted;
    corners[camera] += view.corners.size();
    const auto known = stored.find({camera, frame});
    if (known == stored.end()) return;
    for (const BoardCorner& corner : view.corners) {
      const auto nearest = *std::min_element(known->second.begin(), known->second.end(),
                                             [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
                                               return (corner.pixel - a).norm() < (corner.pixel - b).norm();
                                             });
      const Eigen::Vector2d off = (corner.pixel - nearest).cwiseAbs();
      differences[camera].push_back(off.norm());
      if (camera != 0) continue;
      off_x.push_back(off.x());
      off_y.push_back(off.y());
    }
  });
  // The camera that looks at the board's back, and nothing else, sees it mirrored.
  EXPECT_GE(mirrored[1], 40u);
  EXPECT_EQ(found[1], 0u);
  EXPECT_EQ(mirrored[0] + mirrored[2] + mirrored[3], 0u);
  EXPECT_EQ(upright[0] + upright[2] + upright[3], 0u) << "the board is white on black";
  EXPECT_GE(corners[0], 420u);
  EXPECT_GE(corners[2], 440u);
  EXPECT_GE(corners[3], 255u);
  // Those of the other two cameras are off by more themselves: they fit a plane three and two times worse
  // than ours.
  EXPECT_LT(quantile(off_x, 0.5), 0.1);
  EXPECT_LT(quantile(off_y, 0.5), 0.1);
  std::printf("cam_0: median difference across %.4f (p95 %.4f), down %.4f (p95 %.4f) px\n",
              quantile(off_x, 0.5), quantile(off_x, 0.95), quantile(off_y, 0.5), quantile(off_y, 0.95));
  for (std::uint32_t c = 0; c < 4; ++c) {
    std::printf(
        "cam_%u: %llu views with %llu corners, %llu mirrored; to stored ones median %.4f p95 %.4f px\n", c,
        static_cast<unsigned long long>(found[c]), static_cast<unsigned long long>(corners[c]),
        static_cast<unsigned long long>(mirrored[c]), quantile(differences[c], 0.5),
        quantile(differences[c], 0.95));
  }
}

}  // namespace
}  // namespace glint
