// SPDX-License-Identifier: MIT
// Real recordings, where GLINT_TEST_DATA has them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "host/capture/image_source.hpp"
#include "tests/support/test_data.hpp"
#include "tests/unit/capture/av_fixture.hpp"

namespace glint {
namespace {

using ::testing::SizeIs;
namespace fs = std::filesystem;

constexpr std::uintmax_t kParticleBytes = 15'747'312, kChessboardBytes = 711'386;
constexpr std::uint32_t kWidth_px = 1280, kHeight_px = 1024;

/// The pixels of these TIFFs lie uncompressed behind the eight bytes of the header.
std::vector<std::uint8_t> raw_pixels(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  file.seekg(8);
  std::vector<std::uint8_t> pixels(std::size_t{kWidth_px} * kHeight_px);
  file.read(reinterpret_cast<char*>(pixels.data()), static_cast<std::streamsize>(pixels.size()));
  return pixels;
}

TEST(RealRecordings, ParticleImagesAreReadAsStored) {
  const auto folder = test::test_data("particles-3cam");
  if (!folder || !test::is_intact(*folder, ".tif", kParticleBytes)) GTEST_SKIP();
  const auto source = open_image_source(folder->string(), {});
  ASSERT_THAT(source->cameras(), SizeIs(3));
  ReadStatus last{};
  const auto sets = test::read_all(*source, last);
  EXPECT_EQ(last, ReadStatus::End);
  ASSERT_THAT(sets, SizeIs(4));
  for (std::size_t n = 0; n < 4; ++n) {
    EXPECT_EQ(sets[n].trigger, n + 1);
    for (std::size_t camera = 0; camera < 3; ++camera) {
      ASSERT_TRUE(sets[n].frames[camera]);
      const std::string file = "cam" + std::to_string(camera + 1) + "/0" + std::to_string(n + 1) + ".tif";
      EXPECT_EQ(sets[n].frames[camera]->image.width_px, kWidth_px);
      EXPECT_EQ(sets[n].frames[camera]->image.pixels, raw_pixels(*folder / file)) << file;
    }
  }
}

struct VideoFolder {
  const char* path;
  std::size_t frames;
  std::uintmax_t bytes;
};

class RealVideos : public ::testing::TestWithParam<VideoFolder> {};

TEST_P(RealVideos, GiveAllTheirFrames) {
  const auto folder = test::test_data("caliscope-4cam-charuco-video");
  if (!folder) GTEST_SKIP();
  if (!test::is_intact(*folder / GetParam().path, ".mp4", GetParam().bytes)) GTEST_SKIP();
  const auto source = open_image_source((*folder / GetParam().path).string(), {});
  ASSERT_THAT(source->cameras(), SizeIs(4));
  FramePool pool(test::sizes_of(*source), 2);
  FrameSet set;
  std::size_t sets = 0;
  for (; source->read(pool, set) == ReadStatus::Ok; ++sets) {
    for (std::size_t camera = 0; camera < 4; ++camera) {
      ASSERT_TRUE(set.frames[camera]);
      EXPECT_EQ(set.frames[camera]->image().width_px, 1280U);
      EXPECT_EQ(set.frames[camera]->image().height_px, 720U);
    }
  }
  EXPECT_EQ(sets, GetParam().frames);
  EXPECT_EQ(source->counters().missing + source->counters().damaged, 0U);
  EXPECT_EQ(source->problem(), "");
}

INSTANTIATE_TEST_SUITE_P(
    All, RealVideos,
    ::testing::Values(VideoFolder{"post_optimization/calibration/extrinsic", 57, 7'683'449},
                      VideoFolder{"prerecorded_calibration/calibration/intrinsic", 48, 6'445'224}),
    [](const auto& videos) { return videos.param.frames == 57 ? "extrinsic" : "intrinsic"; });

TEST(RealRecordings, ChessboardJpegsAreReadWhole) {
  const auto folder = test::test_data("opencv-stereo-chessboard");
  if (!folder || !test::is_intact(*folder, ".jpg", kChessboardBytes)) GTEST_SKIP();
  for (const auto& entry : fs::directory_iterator(*folder)) {
    if (entry.path().extension() != ".jpg") continue;
    const GreyImage image = read_grey_image(entry.path());
    EXPECT_EQ(image.width_px, 640U) << entry.path();
    EXPECT_EQ(image.height_px, 480U) << entry.path();
  }
}

}  // namespace
}  // namespace glint
