// SPDX-License-Identifier: MIT
// Videos: frames by place, time from the file, grey range, early ends and damage.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/capture/image_source.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/unit/capture/av_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::ReadSet;
using test::VideoSpec;
using ::testing::HasSubstr;
using ::testing::SizeIs;

const VideoSpec kLossless{"ffv1", "gray", 50};
const VideoSpec kJpeg{"mjpeg", "yuvj420p", 25};
const VideoSpec kMpeg4{"mpeg4", "yuv420p", 25};

std::vector<GreyImage> frames(unsigned count, unsigned from = 0) {
  std::vector<GreyImage> all;
  for (unsigned n = 0; n < count; ++n) all.push_back(test::pattern(64, 48, from + n));
  return all;
}

std::vector<GreyImage> levels(unsigned count) {
  std::vector<GreyImage> all;
  for (unsigned n = 0; n < count; ++n) all.push_back(test::smooth(64, 48, 20 + 15 * n));
  return all;
}

TEST(VideoFolder, FramesArePairedByPlaceAndCarryTheFilesTime) {
  const test::TempDir dir;
  test::write_video(dir.path() / "cam1.mkv", kLossless, frames(6));
  test::write_video(dir.path() / "cam2" / "whatever.mkv", kLossless, frames(6, 40));
  ImageSourceOptions options;
  options.rate_hz = 7.0;  // the files know better
  const auto source = open_image_source(dir.string(), options);
  EXPECT_FALSE(source->live());
  EXPECT_NEAR(source->rate_hz(), 50.0, 1e-6);
  ReadStatus last{};
  const auto sets = test::read_all(*source, last);
  EXPECT_EQ(last, ReadStatus::End);
  ASSERT_THAT(sets, SizeIs(6));
  for (unsigned n = 0; n < 6; ++n) {
    EXPECT_EQ(sets[n].trigger, n);
    EXPECT_NEAR(sets[n].exposed_s, n / 50.0, 1e-9);
    EXPECT_EQ(sets[n].frames[0]->image.pixels, test::pattern(64, 48, n).pixels);
    EXPECT_EQ(sets[n].frames[1]->image.pixels, test::pattern(64, 48, 40 + n).pixels);
  }
  EXPECT_EQ(source->problem(), "");
  EXPECT_EQ(source->counters().frames, 12U);
}

TEST(VideoFolder, VideoRangeIsStretchedAndFullRangeIsKept) {
  const test::TempDir dir;
  test::write_video(dir.path() / "full.avi", kJpeg, levels(10));
  test::write_video(dir.path() / "video.mp4", kMpeg4, levels(10));
  const auto source = open_image_source(dir.string(), {});
  ReadStatus last{};
  const auto sets = test::read_all(*source, last);
  ASSERT_THAT(sets, SizeIs(10));
  for (unsigned n = 0; n < 10; ++n) {
    const GreyImage wanted = test::smooth(64, 48, 20 + 15 * n);
    ASSERT_TRUE(sets[n].frames[0] && sets[n].frames[1]);
    for (std::size_t at = 0; at < wanted.pixels.size(); ++at) {
      const double stored = wanted.pixels[at];
      EXPECT_NEAR(sets[n].frames[0]->image.pixels[at], stored, 4.0);
      EXPECT_NEAR(sets[n].frames[1]->image.pixels[at], (stored - 16.0) * 255.0 / 219.0, 5.0);
    }
  }
}

TEST(VideoFolder, ACameraThatEndsEarlyIsMissingFromThen) {
  const test::TempDir dir;
  test::write_video(dir.path() / "a.mkv", kLossless, frames(3));
  test::write_video(dir.path() / "b.mkv", kLossless, frames(7));
  const auto source = open_image_source(dir.string(), {});
  ReadStatus last{};
  const auto sets = test::read_all(*source, last);
  EXPECT_EQ(last, ReadStatus::End);
  ASSERT_THAT(sets, SizeIs(7));
  for (std::size_t n = 0; n < 7; ++n) {
    EXPECT_EQ(sets[n].frames[0].has_value(), n < 3);
    EXPECT_TRUE(sets[n].frames[1]);
    EXPECT_NEAR(sets[n].exposed_s, static_cast<double>(n) / 50.0, 1e-9);
  }
  EXPECT_EQ(source->counters().missing, 4U);
  EXPECT_THAT(source->problem(), HasSubstr("camera a ended after 3 of 7 frames"));
}

TEST(VideoFolder, ACutFileSaysHowManyFramesItPromised) {
  const test::TempDir dir;
  test::write_video(dir.path() / "a.avi", kJpeg, frames(8));
  test::write_video(dir.path() / "b.avi", kJpeg, frames(8));
  std::filesystem::resize_file(dir.path() / "a.avi", std::filesystem::file_size(dir.path() / "a.avi") / 2);
  const auto source = open_image_source(dir.string(), {});
  ReadStatus last{};
  const auto sets = test::read_all(*source, last);
  EXPECT_EQ(last, ReadStatus::End);
  EXPECT_THAT(sets, SizeIs(8));
  EXPECT_GE(source->counters().missing, 3U);
  EXPECT_EQ(source->counters().missing + source->counters().damaged + source->counters().frames, 16U);
  EXPECT_THAT(source->problem(), HasSubstr("its header promises 8"));
  EXPECT_THAT(source->problem(), HasSubstr("camera a ended after"));
}

TEST(VideoFolder, ADamagedFrameKeepsItsPlace) {
  const test::TempDir dir;
  test::write_video(dir.path() / "a.avi", kJpeg, levels(6));
  // Wipe out what follows the start of the fourth picture's scan.
  std::fstream file(dir.path() / "a.avi", std::ios::in | std::ios::out | std::ios::binary);
  std::string bytes((std::istreambuf_iterator<char>(file)), {});
  std::size_t at = 0;
  for (int picture = 0; picture < 4; ++picture) at = bytes.find("\xff\xd8", at + 1);
  const std::size_t scan = bytes.find("\xff\xda", at), end = bytes.find("\xff\xd9", scan);
  ASSERT_LT(end, bytes.size());
  file.clear();
  file.seekp(static_cast<std::streamoff>(at + 2));
  for (std::size_t n = at + 2; n < end; ++n) file.put('\x5a');
  file.close();
  const auto source = open_image_source(dir.string(), {});
  ReadStatus last{};
  const auto sets = test::read_all(*source, last);
  ASSERT_THAT(sets, SizeIs(6));
  for (std::size_t n = 0; n < 6; ++n) {
    EXPECT_EQ(sets[n].frames[0].has_value(), n != 3) << n;
    if (n == 3) continue;
    EXPECT_NEAR(sets[n].frames[0]->image.pixels[0], 20 + 15 * static_cast<double>(n), 4.0);
  }
  EXPECT_EQ(source->counters().damaged, 1U);
  EXPECT_THAT(source->problem(), HasSubstr("a.avi: frame 3 is damaged"));
}

TEST(VideoFolder, FramesCsvCountsFramesFromZero) {
  const test::TempDir dir;
  test::write_video(dir.path() / "a.mkv", kLossless, frames(3));
  dir.write("frames.csv", "camera,frame,sequence,time_ns\na,0,5,500\na,1,6,600\na,2,8,800\n");
  const auto source = open_image_source(dir.string(), {});
  ReadStatus last{};
  const auto sets = test::read_all(*source, last);
  ASSERT_THAT(sets, SizeIs(3));
  EXPECT_EQ(sets[2].trigger, 8U);
  EXPECT_NEAR(sets[2].exposed_s, 800e-9, 1e-12);
  EXPECT_EQ(source->counters().missing, 1U);
}

TEST(VideoFolder, WhatIsNoVideoIsRefused) {
  const test::TempDir dir;
  dir.write("a.mp4", "this is not a video, however long the text");
  EXPECT_THAT(error_of([&] { open_image_source(dir.string(), {}); }), HasSubstr("camera a: " + dir.string()));
  const test::TempDir two;
  test::write_video(two.path() / "a" / "1.mkv", kLossless, frames(1));
  test::write_video(two.path() / "a" / "2.mkv", kLossless, frames(1));
  EXPECT_THAT(error_of([&] { open_image_source(two.string(), {}); }), HasSubstr("holds 2 videos"));
}

TEST(VideoFolder, SizeIsCheckedAgainstTheRig) {
  const test::TempDir dir;
  test::write_video(dir.path() / "a.mkv", kLossless, frames(1));
  ImageSourceOptions options;
  options.camera_names = {"a"};
  options.camera_sizes = {{64, 49}};
  EXPECT_THAT(error_of([&] { open_image_source(dir.string(), options); }),
              HasSubstr("a.mkv is 64x48, but the rig says 64x49"));
}

TEST(VideoList, OneFileIsOneCamera) {
  const test::TempDir dir;
  test::write_video(dir.path() / "a.mkv", kLossless, frames(2));
  const auto source = open_image_source((dir.path() / "a.mkv").string(), {});
  EXPECT_EQ(source->cameras()[0].name, "cam1");
  ReadStatus last{};
  EXPECT_THAT(test::read_all(*source, last), SizeIs(2));
}

}  // namespace
}  // namespace glint
