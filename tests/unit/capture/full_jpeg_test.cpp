// SPDX-License-Identifier: MIT
// Motion JPEG: what is good comes out right, what is not is never taken for a picture.
#include "host/capture/jpeg/full_decoder.hpp"

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <cstdlib>
#include <random>

#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kWidth = 200, kHeight = 120, kStride = 208;

class JpegDecoding : public ::testing::Test {
 protected:
  JpegResult decode(const std::vector<std::uint8_t>& jpeg, FrameSize size = {kWidth, kHeight}) {
    return decoder_.decode(std::as_bytes(std::span(jpeg)), {pixels_.data(), kStride, size});
  }
  std::vector<std::uint8_t> rows() const {
    std::vector<std::uint8_t> all;
    for (std::size_t y = 0; y < kHeight; ++y)
      all.insert(all.end(), pixels_.begin() + static_cast<std::ptrdiff_t>(y * kStride),
                 pixels_.begin() + static_cast<std::ptrdiff_t>(y * kStride + kWidth));
    return all;
  }

  FullJpegDecoder decoder_;
  std::vector<std::uint8_t> pixels_ = std::vector<std::uint8_t>(kStride * kHeight, 77);
};

TEST_F(JpegDecoding, GivesWhatTurboJpegGives) {
  const auto picture = test::disc_picture(kWidth, kHeight, 1);
  for (const bool colour : {false, true}) {
    for (const int quality : {50, 80, 90, 95, 100}) {
      const auto jpeg = test::jpeg_of(picture, kWidth, kHeight, quality, colour);
      ASSERT_EQ(decode(jpeg), JpegResult::Good) << quality << colour;
      std::vector<std::uint8_t> expected(picture.size());
      const std::unique_ptr<void, int (*)(void*)> other(tjInitDecompress(), tjDestroy);
      ASSERT_EQ(tjDecompress2(other.get(), jpeg.data(), jpeg.size(), expected.data(), kWidth, 0, kHeight,
                              TJPF_GRAY, TJFLAG_ACCURATEDCT),
                0);
      EXPECT_EQ(rows(), expected) << quality << colour;
      for (std::size_t y = 0; y < kHeight; ++y)
        EXPECT_EQ(pixels_[y * kStride + kWidth], 77) << "behind the row's end";
    }
  }
}

TEST_F(JpegDecoding, TablesMayBeMissing) {
  const auto jpeg = test::jpeg_of(test::disc_picture(kWidth, kHeight, 2), kWidth, kHeight, 90, true);
  ASSERT_EQ(decode(jpeg), JpegResult::Good);
  const auto with_tables = rows();
  const auto bare = test::without_huffman_tables(jpeg);
  ASSERT_LT(bare.size() + 400, jpeg.size());
  FullJpegDecoder fresh;
  std::fill(pixels_.begin(), pixels_.end(), std::uint8_t{0});
  ASSERT_EQ(fresh.decode(std::as_bytes(std::span(bare)), {pixels_.data(), kStride, {kWidth, kHeight}}),
            JpegResult::Good);
  EXPECT_EQ(rows(), with_tables);
}

TEST_F(JpegDecoding, EveryTruncationIsSeen) {
  const auto jpeg = test::jpeg_of(test::disc_picture(kWidth, kHeight, 3), kWidth, kHeight, 80);
  for (std::size_t bytes = 0; bytes < jpeg.size(); bytes += bytes < 700 ? 1 : 13) {
    std::vector<std::uint8_t> cut(jpeg.begin(), jpeg.begin() + static_cast<std::ptrdiff_t>(bytes));
    const JpegResult result = decode(cut);
    // Cut within its tables it is not even known to be cut.
    EXPECT_TRUE(result == JpegResult::Truncated || (result == JpegResult::Corrupt && bytes <= 700)) << bytes;
  }
  auto no_end = jpeg;
  no_end.resize(jpeg.size() - 2);
  EXPECT_EQ(decode(no_end), JpegResult::Truncated);
  EXPECT_EQ(decode(jpeg), JpegResult::Good) << "the decoder has recovered";
}

TEST_F(JpegDecoding, OtherSizesAreRefusedAndNothingIsWritten) {
  for (const auto& [width, height] : {std::pair{kWidth, kHeight / 2}, {kWidth * 2, kHeight}, {8u, 8u}}) {
    const auto jpeg = test::jpeg_of(test::disc_picture(width, height, 4), width, height, 80);
    EXPECT_EQ(decode(jpeg), JpegResult::WrongSize);
  }
  EXPECT_EQ(pixels_, std::vector<std::uint8_t>(pixels_.size(), 77));
}

TEST_F(JpegDecoding, PaddingAfterTheEndIsNoHarm) {
  auto jpeg = test::jpeg_of(test::disc_picture(kWidth, kHeight, 5), kWidth, kHeight, 80);
  jpeg.resize(jpeg.size() + 1000, 0);
  EXPECT_EQ(decode(jpeg), JpegResult::Good);
}

/// A flipped byte in the scan may give a picture that is valid and wrong: no decoder can know. But it must be
/// seen in most cases, never write outside, and never spoil the picture after it.
TEST_F(JpegDecoding, CorruptionIsSeenMostlyAndForgotten) {
  const auto good = test::jpeg_of(test::disc_picture(kWidth, kHeight, 6), kWidth, kHeight, 90);
  const auto bare = test::without_huffman_tables(good);
  ASSERT_EQ(decode(good), JpegResult::Good);
  const auto expected = rows();
  std::mt19937 random(7);
  int seen = 0;
  constexpr int kTrials = 400;
  for (int trial = 0; trial < kTrials; ++trial) {
    auto bad = good;
    // A run of lost bytes, as a bus loses them.
    const std::size_t at = 2 + random() % (bad.size() - 100), lost = 1 + random() % 60;
    for (std::size_t n = 0; n < lost; ++n) bad[at + n] = static_cast<std::uint8_t>(random());
    if (decode(bad) != JpegResult::Good) ++seen;
    for (std::size_t y = 0; y < kHeight; ++y) ASSERT_EQ(pixels_[y * kStride + kWidth], 77);
    ASSERT_EQ(decode(trial % 2 == 0 ? good : bare), JpegResult::Good) << trial;
    ASSERT_EQ(rows(), expected) << "tables of a corrupt picture served a good one, trial " << trial;
  }
  EXPECT_GT(seen, kTrials * 3 / 4);
}

TEST_F(JpegDecoding, RandomBytesAreHarmless) {
  std::mt19937 random(8);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<std::uint8_t> bytes(random() % 3000);
    for (auto& byte : bytes) byte = static_cast<std::uint8_t>(random());
    if (bytes.size() > 2) bytes[0] = 0xff, bytes[1] = 0xd8;
    EXPECT_NE(decode(bytes), JpegResult::Good);
  }
}

TEST_F(JpegDecoding, WorkingMemoryIsKept) {
  // The largest picture that a rig is likely to have, in colour: more working memory than the first block.
  const std::uint32_t width = 2592, height = 64;
  const auto jpeg = test::jpeg_of(test::disc_picture(width, height, 9), width, height, 90, true);
  std::vector<std::uint8_t> pixels(std::size_t{width} * height);
  const GreyTarget target{pixels.data(), width, {width, height}};
  for (int n = 0; n < 3; ++n)
    ASSERT_EQ(decoder_.decode(std::as_bytes(std::span(jpeg)), target), JpegResult::Good);
  const std::uint64_t spills = decoder_.spills();
  for (int n = 0; n < 20; ++n)
    ASSERT_EQ(decoder_.decode(std::as_bytes(std::span(jpeg)), target), JpegResult::Good);
  EXPECT_EQ(decoder_.spills(), spills);
}

}  // namespace
}  // namespace glint
