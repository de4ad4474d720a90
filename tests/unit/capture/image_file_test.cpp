// SPDX-License-Identifier: MIT
// Single image files: exact grey in and out, and every kind of damage noticed.
#include "host/capture/image_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "host/base/error.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/unit/capture/av_fixture.hpp"

namespace glint {
namespace {

using test::encode_image;
using test::error_of;
using test::pattern;
using ::testing::HasSubstr;

struct Format {
  const char* encoder;
  const char* pixel_format;
};

std::string name_of(const ::testing::TestParamInfo<Format>& info) {
  return std::string(info.param.encoder) + "_" + info.param.pixel_format;
}

class LosslessImage : public ::testing::TestWithParam<Format> {};

TEST_P(LosslessImage, GreyComesBackAsItIs) {
  const test::TempDir dir;
  for (const FrameSize size : {FrameSize{64, 48}, FrameSize{37, 21}, FrameSize{1, 1}}) {
    const GreyImage image = pattern(size.width_px, size.height_px, 3);
    const auto path = dir.write("image", encode_image(GetParam().encoder, GetParam().pixel_format, image));
    const GreyImage back = read_grey_image(path);
    EXPECT_EQ(back.width_px, size.width_px);
    EXPECT_EQ(back.height_px, size.height_px);
    EXPECT_EQ(back.pixels, image.pixels);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LosslessImage,
                         ::testing::Values(Format{"png", "gray"}, Format{"png", "rgb24"},
                                           Format{"png", "pal8"}, Format{"tiff", "gray"},
                                           Format{"tiff", "rgb24"}, Format{"tiff", "gray16le"},
                                           Format{"tiff", "pal8"}, Format{"bmp", "gray"},
                                           Format{"bmp", "bgr24"}, Format{"bmp", "pal8"},
                                           Format{"pgm", "gray"}),
                         name_of);

TEST(ImageFile, JpegComesBackNearly) {
  const test::TempDir dir;
  const GreyImage image = test::smooth(64, 48, 100);
  const GreyImage back = read_grey_image(dir.write("a.jpg", encode_image("mjpeg", "yuvj420p", image)));
  ASSERT_EQ(back.pixels.size(), image.pixels.size());
  for (std::size_t n = 0; n < image.pixels.size(); ++n) {
    EXPECT_LE(std::abs(int{back.pixels[n]} - int{image.pixels[n]}), 2);
  }
}

TEST(ImageFile, JpegUsesTheFullRange) {
  const test::TempDir dir;
  for (const std::uint8_t level : {std::uint8_t{0}, std::uint8_t{255}}) {
    GreyImage image{32, 32, std::vector<std::uint8_t>(32 * 32, level)};
    EXPECT_EQ(read_grey_image(dir.write("a.jpg", encode_image("mjpeg", "yuvj420p", image))).pixels,
              image.pixels);
  }
}

TEST(ImageFile, ColourBecomesLuma) {
  const test::TempDir dir;
  const auto path = dir.write("a.ppm", std::string("P6\n3 1\n255\n\xff\0\0\0\xff\0\0\0\xff", 20));
  EXPECT_THAT(read_grey_image(path).pixels, ::testing::ElementsAre(77, 149, 29));
}

TEST(ImageFile, DeepPgmIsScaledByItsOwnLargestValue) {
  const test::TempDir dir;
  const auto path = dir.write("a.pgm", std::string("P5\n3 1\n4095\n\x00\x00\x08\x00\x0f\xff", 18));
  EXPECT_THAT(read_grey_image(path).pixels, ::testing::ElementsAre(0, 128, 255));
}

class CutImage : public ::testing::TestWithParam<Format> {};

/// Wherever a file ends too early, it is either refused or (the last few bytes of some formats carry nothing)
/// complete.
TEST_P(CutImage, IsNeverTakenForWhole) {
  const test::TempDir dir;
  const GreyImage image = pattern(64, 48, 5);
  const std::string whole = encode_image(GetParam().encoder, GetParam().pixel_format, image);
  const GreyImage reference = read_grey_image(dir.write("whole", whole));
  std::size_t accepted = 0;
  for (std::size_t length = 0; length < whole.size(); length += length < 64 ? 1 : 13) {
    const auto path = dir.write("cut", whole.substr(0, length));
    try {
      EXPECT_EQ(read_grey_image(path).pixels, reference.pixels)
          << "cut to " << length << " of " << whole.size();
      ++accepted;
      EXPECT_GE(length + 16, whole.size());
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr((dir.path() / "cut").string()));
    }
  }
  EXPECT_LE(accepted, 2U);
}

INSTANTIATE_TEST_SUITE_P(All, CutImage,
                         ::testing::Values(Format{"png", "gray"}, Format{"tiff", "gray"},
                                           Format{"bmp", "gray"}, Format{"mjpeg", "yuvj420p"},
                                           Format{"pgm", "gray"}),
                         name_of);

TEST(ImageFile, UnreadableFilesAreNamedWithTheReason) {
  const test::TempDir dir;
  EXPECT_THAT(error_of([&] { read_grey_image(dir.path() / "none.png"); }),
              HasSubstr("none.png: No such file or directory"));
  EXPECT_THAT(error_of([&] { read_grey_image(dir.write("empty.png", "")); }),
              HasSubstr("empty.png: the file is empty"));
  EXPECT_THAT(error_of([&] { read_grey_image(dir.write("text.png", "hello")); }), HasSubstr("not a PGM"));
  EXPECT_THAT(error_of([&] { read_grey_image(dir.path()); }), HasSubstr(dir.string()));
}

TEST(ImageFile, WritersKeepEveryPixel) {
  const test::TempDir dir;
  const GreyImage wide = pattern(50, 20, 1);
  const gpu::ImageView part{wide.pixels.data(), 33, 20, 50, gpu::PixelFormat::Grey8};
  write_png_grey(dir.path() / "a.png", part);
  write_pgm(dir.path() / "a.pgm", part);
  for (const char* name : {"a.png", "a.pgm"}) {
    const GreyImage back = read_grey_image(dir.path() / name);
    ASSERT_EQ(back.width_px, 33U);
    ASSERT_EQ(back.height_px, 20U);
    for (std::size_t y = 0; y < 20; ++y) {
      for (std::size_t x = 0; x < 33; ++x) ASSERT_EQ(back.pixels[y * 33 + x], wide.pixels[y * 50 + x]);
    }
  }
  const std::vector<std::uint8_t> rgb{255, 0, 0, 0, 255, 0, 0, 0, 255, 9, 9, 9};
  write_png_rgb(dir.path() / "c.png", 2, 2, rgb);
  EXPECT_THAT(read_grey_image(dir.path() / "c.png").pixels, ::testing::ElementsAre(77, 149, 29, 9));
}

TEST(ImageFile, WhatCannotBeWrittenIsNamedAndLeavesNothingBehind) {
  const test::TempDir dir;
  const GreyImage image = pattern(64, 64, 1);
  EXPECT_THAT(error_of([&] { write_pgm(dir.path() / "no" / "such" / "a.pgm", image.view()); }),
              HasSubstr("a.pgm: cannot be written: No such file or directory"));
  // A device that is always full. It must still be there afterwards.
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "SKIPPED: no /dev/full";
  EXPECT_THAT(error_of([&] { write_pgm("/dev/full", image.view()); }),
              HasSubstr("/dev/full: cannot be written: No space left on device"));
  EXPECT_THAT(error_of([&] { write_png_grey("/dev/full", image.view()); }), HasSubstr("No space left"));
  EXPECT_TRUE(std::filesystem::exists("/dev/full"));
}

}  // namespace
}  // namespace glint
