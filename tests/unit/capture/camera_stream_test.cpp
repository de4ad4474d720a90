// SPDX-License-Identifier: MIT
// One camera: pixels, numbers, stamps, and frames that are not fit for use.
#include "host/capture/v4l2/camera_stream.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/capture/camera_stream_fixture.hpp"
#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint {
namespace {

using std::chrono::milliseconds;
using test::FakeFrame;
using test::FakeSize;

class Stream : public ::testing::Test, protected test::StreamFixture {
 protected:
  void expect_good(std::uint8_t grey) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    EXPECT_EQ(received_.flaw, FrameFlaw::None);
    EXPECT_FALSE(received_.frame.damaged);
    ASSERT_NE(received_.frame.image().pixels, nullptr);
    EXPECT_EQ(pixel(0, 0), grey);
    EXPECT_EQ(pixel(63, 47), grey);
  }
};

TEST_F(Stream, GreyArrivesInOrderWithStampsAndNumbers) {
  start();
  EXPECT_FALSE(stream_->in_place());
  Timestamp last{};
  for (std::uint8_t n = 0; n < 40; ++n) {
    expect_good(n);
    EXPECT_EQ(received_.frame.sequence, n);
    EXPECT_EQ(received_.frame.stamp, StampPoint::StartOfExposure);
    EXPECT_TRUE(n == 0 || received_.frame.stamped - last == milliseconds(10));
    last = received_.frame.stamped;
  }
  EXPECT_EQ(camera().lost, 0u);
}

TEST_F(Stream, GreyGoesStraightIntoThePoolWhereTheDriverTakesPointers) {
  camera().takes_pointers = true;
  start();
  ASSERT_TRUE(stream_->in_place());
  EXPECT_EQ(driver_.mappings(), 0);
  for (std::uint8_t n = 0; n < 40; ++n) expect_good(n);
  const auto slot = received_.frame.pixels();
  const auto memory = pool_->memory();
  EXPECT_GE(reinterpret_cast<std::byte*>(slot.data()), memory.data());
}

TEST_F(Stream, AFrameInHandIsNeverOverwritten) {
  camera().takes_pointers = true;
  start();
  expect_good(0);
  Frame held = std::move(received_.frame);
  for (std::uint8_t n = 1; n < 60; ++n) expect_good(n);
  EXPECT_EQ(held.pixels()[0], 0);
  EXPECT_EQ(held.pixels()[63], 0);
}

TEST_F(Stream, PointersOnlyWhereRowsFit) {
  camera().takes_pointers = true;
  camera().more_stride_bytes = 32;
  start();
  EXPECT_FALSE(stream_->in_place());
  camera().frame = [](std::uint64_t, FakeFrame& frame) {
    frame.bytes.resize(96 * 48);
    for (std::size_t n = 0; n < frame.bytes.size(); ++n) frame.bytes[n] = n % 96 < 64 ? 5 : 200;
    return true;
  };
  ASSERT_EQ(next_frame(), StreamStatus::Frame);
  for (std::size_t y = 0; y < 48; ++y) {
    for (std::size_t x = 0; x < 64; ++x) ASSERT_EQ(pixel(x, y), 5);
  }
}

TEST_F(Stream, LuminanceOfYuyvAndNv12) {
  for (const std::uint32_t fourcc : {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_NV12}) {
    camera().formats = {{fourcc, {FakeSize{}}}};
    camera().fourcc = 0;
    camera().frame = [fourcc](std::uint64_t, FakeFrame& frame) {
      frame.bytes.assign(64 * 48 * 2, 128);
      for (std::size_t n = 0; n < 64 * 48; ++n)
        frame.bytes[fourcc == V4L2_PIX_FMT_YUYV ? 2 * n : n] = static_cast<std::uint8_t>(n * 7);
      if (fourcc == V4L2_PIX_FMT_NV12) frame.bytes.resize(64 * 48 * 3 / 2);
      return true;
    };
    start();
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    ASSERT_EQ(received_.flaw, FrameFlaw::None);
    for (std::size_t n = 0; n < 64 * 48; ++n)
      ASSERT_EQ(pixel(n % 64, n / 64), static_cast<std::uint8_t>(n * 7)) << fourcc;
  }
}

TEST_F(Stream, JpegsGoodCutCorruptAndOfAnotherSize) {
  camera().formats = {{V4L2_PIX_FMT_MJPEG, {FakeSize{}}}};
  const auto good = test::jpeg_of(test::disc_picture(64, 48, 1), 64, 48, 90, true);
  const auto other = test::jpeg_of(test::disc_picture(64, 56, 1), 64, 56, 90, true);
  camera().frame = [=](std::uint64_t pulse, FakeFrame& frame) {
    frame.bytes = pulse % 5 == 4 ? other : good;
    if (pulse % 5 == 1) frame.bytes.resize(good.size() * 2 / 3);
    if (pulse % 5 == 2) frame.bytes[1] = 0;
    if (pulse % 5 == 3) frame.bytes.clear();
    return true;
  };
  start();
  const FrameFlaw expected[] = {FrameFlaw::None, FrameFlaw::TruncatedJpeg, FrameFlaw::CorruptJpeg,
                                FrameFlaw::TruncatedJpeg, FrameFlaw::WrongSize};
  for (std::uint32_t n = 0; n < 25; ++n) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    EXPECT_EQ(received_.flaw, expected[n % 5]) << n;
    EXPECT_EQ(received_.frame.sequence, n);
    EXPECT_EQ(received_.frame.damaged, n % 5 != 0);
    EXPECT_EQ(received_.frame.image().pixels == nullptr, n % 5 != 0) << "half a picture was handed on";
  }
}

/// While we did not come, frames queued up: the old ones are not decoded, so that the newest is soon there.
TEST_F(Stream, JpegsThatWaitedTooLongAreNotDecoded) {
  const auto jpeg = test::jpeg_of(test::disc_picture(64, 48, 1), 64, 48, 90);
  camera().formats[0].fourcc = V4L2_PIX_FMT_MJPEG;
  camera().frame = [&](std::uint64_t, FakeFrame& frame) {
    frame.bytes = jpeg;
    return true;
  };
  start();
  for (int n = 0; n < 3; ++n) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    EXPECT_EQ(received_.flaw, FrameFlaw::None);
  }
  received_.frame = {};
  driver_.with(path_, [](test::FakeCamera& c) { c.started -= milliseconds(55); });
  std::vector<FrameFlaw> flaws;
  for (int n = 0; n < 8; ++n) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    flaws.push_back(received_.flaw);
  }
  using enum FrameFlaw;
  EXPECT_THAT(flaws, ::testing::ElementsAre(TooOld, TooOld, TooOld, None, None, None, None, None));
}

/// A driver's clock that loses 20 us with every frame: after 2,000 frames stamps are four periods behind, and
/// still no frame is old.
TEST_F(Stream, AClockThatDriftsMakesNoFrameOld) {
  const auto jpeg = test::jpeg_of(test::disc_picture(64, 48, 1), 64, 48, 90);
  camera().formats[0].fourcc = V4L2_PIX_FMT_MJPEG;
  camera().frame = [&](std::uint64_t pulse, FakeFrame& frame) {
    frame.bytes = jpeg;
    const auto stamp = camera().started + milliseconds(10) * pulse - std::chrono::microseconds(20) * pulse;
    const auto us = std::chrono::duration_cast<std::chrono::microseconds>(stamp.time_since_epoch()).count();
    frame.stamp = timeval{us / 1'000'000, us % 1'000'000};
    return true;
  };
  start();
  for (int n = 0; n < 2000; ++n) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    ASSERT_EQ(received_.flaw, FrameFlaw::None) << n;
  }
  EXPECT_EQ(received_.frame.stamp, StampPoint::StartOfExposure);
  EXPECT_GT(received_.arrived - received_.frame.stamped, milliseconds(35));
}

TEST_F(Stream, FlaggedAndShortFramesAreDamaged) {
  camera().frame = [](std::uint64_t pulse, FakeFrame& frame) {
    frame.bytes.assign(64 * 48, 9);
    if (pulse == 1) frame.flags |= V4L2_BUF_FLAG_ERROR;
    if (pulse == 2) frame.bytesused = 64 * 24;
    if (pulse == 3) frame.bytesused = 0;
    return true;
  };
  for (const bool in_place : {false, true}) {
    camera().takes_pointers = in_place;
    start();
    ASSERT_EQ(stream_->in_place(), in_place);
    for (const FrameFlaw flaw :
         {FrameFlaw::None, FrameFlaw::Flagged, FrameFlaw::Short, FrameFlaw::Short, FrameFlaw::None}) {
      ASSERT_EQ(next_frame(), StreamStatus::Frame);
      EXPECT_EQ(received_.flaw, flaw);
    }
  }
}

TEST_F(Stream, AFrameNeverSentLeavesNoGapAndALostOneDoes) {
  camera().frame = [](std::uint64_t pulse, FakeFrame& frame) {
    if (pulse == 2) return false;
    frame.bytes.assign(64 * 48, 1);
    return true;
  };
  start();
  std::vector<std::uint32_t> sequences;
  std::vector<Timestamp> stamps;
  for (int n = 0; n < 4; ++n) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    sequences.push_back(received_.frame.sequence);
    stamps.push_back(received_.frame.stamped);
  }
  EXPECT_THAT(sequences, ::testing::ElementsAre(0, 1, 2, 3));
  EXPECT_EQ(stamps[2] - stamps[1], milliseconds(20));
  // We do not come for 20 periods: six buffers are full, the rest is lost.
  received_.frame = {};
  (void)driver_.poll(-1, milliseconds(0));
  driver_.with(path_, [](test::FakeCamera& c) { c.started -= milliseconds(200); });
  std::uint32_t last = 3, gaps = 0;
  for (int n = 0; n < 12; ++n) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    gaps += received_.frame.sequence - last - 1;
    last = received_.frame.sequence;
  }
  EXPECT_EQ(gaps, camera().lost);
  EXPECT_GE(gaps, 10u);
}

TEST_F(Stream, SequenceNumbersWrap) {
  camera().next_sequence = UINT32_MAX - 1;
  start();
  for (const std::uint32_t expected : {UINT32_MAX - 1, UINT32_MAX, 0u, 1u}) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    EXPECT_EQ(received_.frame.sequence, expected);
  }
}

TEST_F(Stream, StampsThatRunAwayAreReplaced) {
  camera().frame = [](std::uint64_t pulse, FakeFrame& frame) {
    frame.bytes.assign(64 * 48, 1);
    if (pulse == 1) frame.stamp = timeval{9223372036, 850000};
    if (pulse == 2) frame.stamp = timeval{-9223372037, 160000};
    return true;
  };
  start();
  for (const StampPoint point : {StampPoint::StartOfExposure, StampPoint::HostArrival,
                                 StampPoint::HostArrival, StampPoint::StartOfExposure}) {
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    EXPECT_EQ(received_.frame.stamp, point);
    EXPECT_LT(std::abs(seconds_between(received_.frame.stamped, received_.arrived)), 0.02);
  }
}

}  // namespace
}  // namespace glint
