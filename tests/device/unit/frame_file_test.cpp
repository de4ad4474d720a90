// SPDX-License-Identifier: MIT
// Files of frames there and back, and the pulse in a picture.
#include "tests/device/frame_file/frame_file.hpp"

#include <gtest/gtest.h>

#include <array>

#include "host/base/error.hpp"
#include "tests/device/frame_file/pulse_tag.hpp"
#include "tests/support/temp_dir.hpp"

namespace glint::device {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST(FrameFile, ComesBackAsWritten) {
  const test::TempDir folder;
  const auto path = folder.path() / "f";
  FrameFileWriter writer(path, {2, 1280, 800, 2, 90.0});
  for (std::uint8_t i = 0; i < 6; ++i) writer.add(Bytes(i + 1u, i));
  writer.finish();
  const FrameFile file(path);
  EXPECT_EQ(file.header().width_px, 1280u);
  EXPECT_DOUBLE_EQ(file.header().rate_hz, 90.0);
  EXPECT_EQ(Bytes(file.frame(1, 0).begin(), file.frame(1, 0).end()), Bytes(3, 2));
  EXPECT_EQ(file.frame(2, 1).size(), file.frame(0, 1).size()) << "back and forth";
  EXPECT_EQ(Bytes(file.dark(1).begin(), file.dark(1).end()), Bytes(6, 5));
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
  EXPECT_THROW(FrameFile{path}, Error);
}

TEST(FrameFile, TellsWhenFramesAreMissing) {
  const test::TempDir folder;
  FrameFileWriter writer(folder.path() / "f", {1, 8, 8, 1, 90.0});
  writer.add(Bytes{1});
  EXPECT_THROW(writer.finish(), Error);
}

TEST(BackAndForth, NeverJumps) {
  const std::array<std::uint64_t, 9> expected{0, 1, 2, 3, 2, 1, 0, 1, 2};
  for (std::uint64_t tick = 0; tick < expected.size(); ++tick)
    EXPECT_EQ(back_and_forth(tick, 4), expected[tick]);
  EXPECT_EQ(back_and_forth(7, 1), 0u);
}

TEST(PulseTag, RidesInAComment) {
  const Bytes jpeg{0xFF, 0xD8, 0xFF, 0xDB, 1, 2, 0xFF, 0xD9};
  const Bytes tagged = with_pulse_comment(jpeg, 123456789012);
  EXPECT_EQ(pulse_of_comment(tagged), 123456789012u);
  EXPECT_FALSE(pulse_of_comment(jpeg));
  EXPECT_TRUE(ends_whole(tagged));
  EXPECT_FALSE(ends_whole(std::span(tagged).first(tagged.size() - 1)));
}

TEST(PulseTag, HidesInDarkPixels) {
  std::array<std::uint8_t, kGreyTagPixels> pixels{};
  put_pulse(pixels, 0x123456789ABCDEFu);
  for (const std::uint8_t pixel : pixels) EXPECT_LT(pixel, 16);
  EXPECT_EQ(get_pulse(pixels), 0x123456789ABCDEFu);
}

}  // namespace
}  // namespace glint::device
