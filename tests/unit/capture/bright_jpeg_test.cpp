// SPDX-License-Identifier: MIT
// Pictures of which only the bright part is made: the same bright pixels as in whole pictures, and no others.
#include "host/capture/jpeg/bright_decoder.hpp"

#include <gtest/gtest.h>
#include <turbojpeg.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <utility>
#include <vector>

#include "host/capture/jpeg/jpeg_decoder.hpp"
#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint {
namespace {

using Grey = std::vector<std::uint8_t>;

std::span<const std::byte> bytes_of(const Grey& jpeg) { return std::as_bytes(std::span(jpeg)); }

Grey jpeg_of(const Grey& picture, FrameSize size, int quality, int sampling, bool restarts = false) {
  Grey jpeg = test::sampled_jpeg_of(picture, size.width_px, size.height_px, quality, sampling, restarts);
  if (restarts && size.height_px > 32) {
    constexpr std::uint8_t kRestart[] = {0xff, 0xd0};
    EXPECT_NE(std::search(jpeg.begin(), jpeg.end(), std::begin(kRestart), std::end(kRestart)), jpeg.end());
  }
  return jpeg;
}

class BrightJpeg : public ::testing::Test {
 protected:
  static Grey whole(const Grey& jpeg, FrameSize size) {
    Grey pixels(std::size_t{size.width_px} * size.height_px);
    FullJpegDecoder decoder;
    EXPECT_EQ(decoder.decode(bytes_of(jpeg), {pixels.data(), size.width_px, size}), JpegResult::Good);
    return pixels;
  }

  /// Decodes with `limit` everywhere and compares with the whole picture; returns how many pixels are bright.
  std::size_t compare(const Grey& jpeg, FrameSize size, const Grey& limit) {
    const Grey expected = whole(jpeg, size);
    const std::size_t stride = size.width_px + 13;
    Grey pixels(stride * size.height_px, 77);
    decoder_.set_limit(limit, size);
    EXPECT_TRUE(decoder_.decode(bytes_of(jpeg), {pixels.data(), stride, size}));
    std::size_t bright = 0;
    for (std::size_t y = 0; y < size.height_px; ++y) {
      for (std::size_t x = 0; x < size.width_px; ++x) {
        const int ours = pixels[y * stride + x], theirs = expected[y * size.width_px + x],
                  most = limit[y * size.width_px + x];
        if (ours > most) ++bright;
        if (ours > most || theirs > most) {
          EXPECT_EQ(ours, theirs) << x << ' ' << y;
        }
      }
      for (std::size_t x = size.width_px; x < stride; ++x)
        EXPECT_EQ(pixels[y * stride + x], 77) << "behind the row's end";
    }
    return bright;
  }

  BrightJpegDecoder decoder_;
};

TEST_F(BrightJpeg, BrightPixelsAreThoseOfTheWholePicture) {
  unsigned seed = 1;
  for (const FrameSize size : {FrameSize{200, 120}, {203, 117}, {8, 8}, {1, 1}, {640, 16}}) {
    const Grey picture = test::disc_picture(size.width_px, size.height_px, ++seed);
    for (const int sampling : {TJSAMP_GRAY, TJSAMP_422, TJSAMP_420, TJSAMP_444, TJSAMP_440, TJSAMP_411}) {
      for (const int quality : {1, 30, 80, 95, 100}) {
        for (const bool restarts : {false, true}) {
          SCOPED_TRACE(::testing::Message()
                       << size.width_px << 'x' << size.height_px << " sampling " << sampling << " quality "
                       << quality << " restarts " << restarts);
          compare(jpeg_of(picture, size, quality, sampling, restarts), size, Grey(picture.size(), 40));
          if (HasFailure()) return;
        }
      }
    }
  }
}

TEST_F(BrightJpeg, NoiseOfAnyStrengthAndLimitsOfAnyHeight) {
  constexpr FrameSize kSize{128, 64};
  std::mt19937 random(3);
  std::size_t bright = 0;
  for (const double noise : {0.0, 1.0, 5.0, 30.0, 120.0}) {
    std::normal_distribution<double> grain(60.0, noise + 1e-9);
    Grey picture(kSize.width_px * kSize.height_px), limit(picture.size());
    for (std::uint8_t& pixel : picture)
      pixel = static_cast<std::uint8_t>(std::clamp(std::lround(grain(random)), 0L, 255L));
    for (const unsigned base : {0u, 50u, 64u, 80u, 200u, 255u}) {
      for (std::uint8_t& one : limit)
        one = static_cast<std::uint8_t>(std::min(255u, base + static_cast<unsigned>(random() % 9)));
      for (const int quality : {50, 90, 100})
        bright += compare(jpeg_of(picture, kSize, quality, TJSAMP_GRAY), kSize, limit);
    }
  }
  EXPECT_GT(bright, 10'000u);
}

TEST_F(BrightJpeg, MostOfADarkPictureIsNotTransformed) {
  constexpr FrameSize kSize{640, 400};
  const Grey picture = test::disc_picture(kSize.width_px, kSize.height_px, 5);
  EXPECT_GT(compare(jpeg_of(picture, kSize, 90, TJSAMP_422), kSize, Grey(picture.size(), 30)), 100u);
  EXPECT_EQ(decoder_.blocks(), 80u * 50u);
  EXPECT_LE(decoder_.transformed(), 6u * 4u) << "six discs, each on four blocks at most";
  EXPECT_GE(decoder_.transformed(), 6u);
}

TEST_F(BrightJpeg, TablesMayBeMissing) {
  constexpr FrameSize kSize{200, 120};
  const Grey picture = test::disc_picture(kSize.width_px, kSize.height_px, 6);
  const Grey jpeg = test::jpeg_of(picture, kSize.width_px, kSize.height_px, 90, true);
  compare(test::without_huffman_tables(jpeg), kSize, Grey(picture.size(), 40));
}

TEST_F(BrightJpeg, WhatItDoesNotKnowIsLeftToTheOther) {
  constexpr FrameSize kSize{64, 64};
  const Grey picture = test::disc_picture(64, 64, 7);
  decoder_.set_limit(Grey(picture.size(), 40), kSize);
  Grey pixels(picture.size());
  const GreyTarget target{pixels.data(), 64, kSize};
  const Grey jpeg = jpeg_of(picture, kSize, 90, TJSAMP_GRAY);
  EXPECT_TRUE(decoder_.decode(bytes_of(jpeg), target));
  EXPECT_FALSE(
      decoder_.decode(bytes_of(jpeg_of(test::disc_picture(64, 32, 7), {64, 32}, 90, TJSAMP_GRAY)), target))
      << "another size";
  setenv("TJ_PROGRESSIVE", "1", 1);
  const Grey progressive = jpeg_of(picture, kSize, 90, TJSAMP_GRAY);
  unsetenv("TJ_PROGRESSIVE");
  EXPECT_FALSE(decoder_.decode(bytes_of(progressive), target));
  setenv("TJ_ARITHMETIC", "1", 1);
  const Grey arithmetic = jpeg_of(picture, kSize, 90, TJSAMP_GRAY);
  unsetenv("TJ_ARITHMETIC");
  EXPECT_FALSE(decoder_.decode(bytes_of(arithmetic), target));
}

/// Places in the head of a JPEG of libjpeg-turbo's making.
std::size_t segment(const Grey& jpeg, std::uint8_t marker) {
  const std::array<std::uint8_t, 2> start{0xff, marker};
  const auto at = std::search(jpeg.begin(), jpeg.end(), start.begin(), start.end());
  EXPECT_NE(at, jpeg.end());
  return static_cast<std::size_t>(at - jpeg.begin());
}

/// What libjpeg-turbo refuses, or shows in another way than its first component would.
TEST_F(BrightJpeg, HeadsThatOnlyTheOtherUnderstandsAreLeftToIt) {
  constexpr FrameSize kSize{64, 64};
  const Grey picture = test::disc_picture(64, 64, 7);
  const Grey good = jpeg_of(picture, kSize, 90, TJSAMP_444);
  const std::size_t jfif = segment(good, 0xe0), frame = segment(good, 0xc0), scan = segment(good, 0xda);
  const auto with = [&good](std::initializer_list<std::pair<std::size_t, int>> changes) {
    Grey changed = good;
    for (const auto& [at, byte] : changes) changed[at] = static_cast<std::uint8_t>(byte);
    return changed;
  };
  const auto adobe = [&](std::uint8_t colours) {
    const std::array<std::uint8_t, 16> segment{0xff, 0xee, 0,   14, 'A', 'd', 'o', 'b',
                                               'e',  0,    100, 0,  0,   0,   0,   colours};
    Grey changed = good;
    const auto begin = changed.begin() + static_cast<std::ptrdiff_t>(jfif);
    changed.erase(begin, begin + 18);
    changed.insert(begin, segment.begin(), segment.end());
    return changed;
  };
  const std::size_t first = frame + 10;  // its components: name, sampling, quantizer
  const std::size_t in_scan = scan + 5;  // name, tables
  Grey nameless = with({{first, 'R'}, {first + 3, 'G'}, {first + 6, 'B'}});
  for (std::size_t n = 0; n < 3; ++n) nameless[in_scan + 2 * n] = static_cast<std::uint8_t>("RGB"[n]);
  nameless[jfif + 4] = 'X';  // no JFIF either

  decoder_.set_limit(Grey(picture.size(), 40), kSize);
  Grey pixels(picture.size());
  const GreyTarget target{pixels.data(), 64, kSize};
  EXPECT_TRUE(decoder_.decode(bytes_of(good), target));
  EXPECT_TRUE(decoder_.decode(bytes_of(adobe(1)), target)) << "brightness and two differences";
  EXPECT_FALSE(decoder_.decode(bytes_of(adobe(0)), target)) << "red, green, blue";
  EXPECT_FALSE(decoder_.decode(bytes_of(nameless), target)) << "red, green, blue";
  EXPECT_FALSE(decoder_.decode(bytes_of(with({{jfif + 9, 3}})), target)) << "JFIF 3";
  EXPECT_FALSE(decoder_.decode(bytes_of(with({{first + 5, 3}})), target)) << "colour without a quantizer";
  EXPECT_FALSE(decoder_.decode(bytes_of(with({{first + 1, 0x44}})), target)) << "18 blocks in a unit";
  FullJpegDecoder full;
  EXPECT_EQ(full.decode(bytes_of(adobe(0)), target), JpegResult::Good) << "the other knows it";
  EXPECT_EQ(full.decode(bytes_of(nameless), target), JpegResult::Good);
  EXPECT_EQ(full.decode(bytes_of(with({{jfif + 9, 3}})), target), JpegResult::Corrupt);
  EXPECT_EQ(full.decode(bytes_of(with({{first + 5, 3}})), target), JpegResult::Corrupt);
  EXPECT_EQ(full.decode(bytes_of(with({{first + 1, 0x44}})), target), JpegResult::Corrupt);
}

/// A picture is taken for good only if libjpeg-turbo takes it for good, and shows the same then.
TEST_F(BrightJpeg, IsNeverMoreLenientThanTheOther) {
  constexpr FrameSize kSize{200, 120};
  const Grey picture = test::disc_picture(kSize.width_px, kSize.height_px, 8);
  const Grey limit(picture.size(), 40);
  decoder_.set_limit(limit, kSize);
  std::mt19937 random(9);
  Grey pixels(picture.size()), expected(picture.size());
  FullJpegDecoder full;
  int taken = 0, refused = 0;
  for (int trial = 0; trial < 3000; ++trial) {
    Grey bad = jpeg_of(picture, kSize, trial % 2 == 0 ? 80 : 95, trial % 3 == 0 ? TJSAMP_422 : TJSAMP_GRAY,
                       trial % 5 == 0);
    const std::size_t from = trial % 4 == 0 ? 2 : 600;
    const std::size_t at = from + random() % (bad.size() - from - 64);
    switch (trial % 3) {
      case 0:
        bad[at] = static_cast<std::uint8_t>(random());
        break;
      case 1:
        for (std::size_t n = 0; n < random() % 60; ++n) bad[at + n] = static_cast<std::uint8_t>(random());
        break;
      default:
        bad.erase(bad.begin() + static_cast<std::ptrdiff_t>(at),
                  bad.begin() + static_cast<std::ptrdiff_t>(at + 1 + random() % 20));
    }
    if (!decoder_.decode(bytes_of(bad), {pixels.data(), kSize.width_px, kSize})) {
      ++refused;
      continue;
    }
    ++taken;
    ASSERT_EQ(full.decode(bytes_of(bad), {expected.data(), kSize.width_px, kSize}), JpegResult::Good)
        << trial;
    for (std::size_t n = 0; n < pixels.size(); ++n) {
      if (pixels[n] > limit[n] || expected[n] > limit[n]) {
        ASSERT_EQ(pixels[n], expected[n]) << trial;
      }
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_GT(taken, 50) << "some damage cannot be seen";
}

/// With and without a limit, and back: what the two decoders share is nothing.
TEST_F(BrightJpeg, BothTogetherJudgeEveryPicture) {
  constexpr FrameSize kSize{200, 120};
  const Grey picture = test::disc_picture(kSize.width_px, kSize.height_px, 11);
  const Grey jpeg = jpeg_of(picture, kSize, 90, TJSAMP_422);
  Grey pixels(picture.size());
  const GreyTarget target{pixels.data(), kSize.width_px, kSize};
  JpegDecoder decoder;
  ASSERT_EQ(decoder.decode(bytes_of(jpeg), target), JpegResult::Good);
  EXPECT_EQ(pixels, whole(jpeg, kSize));
  decoder.set_limit(Grey(picture.size(), 40), kSize);
  ASSERT_EQ(decoder.decode(bytes_of(jpeg), target), JpegResult::Good);
  EXPECT_NE(pixels, whole(jpeg, kSize));
  Grey cut = jpeg;
  cut.resize(jpeg.size() - 2);
  EXPECT_EQ(decoder.decode(bytes_of(cut), target), JpegResult::Truncated);
  cut = jpeg;
  cut.erase(cut.end() - 200, cut.end() - 2);  // the end marker stays
  EXPECT_NE(decoder.decode(bytes_of(cut), target), JpegResult::Good);
  EXPECT_EQ(
      decoder.decode(bytes_of(jpeg_of(test::disc_picture(64, 64, 7), {64, 64}, 90, TJSAMP_GRAY)), target),
      JpegResult::WrongSize);
}

}  // namespace
}  // namespace glint
