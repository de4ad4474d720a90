// SPDX-License-Identifier: MIT
// The frame pool: layout of the slab, lending and returning, also across threads.
#include "host/frames/frame_pool.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <thread>
#include <utility>
#include <vector>

#include "host/base/error.hpp"
#include "host/base/ring.hpp"

namespace glint {
namespace {

constexpr CameraId kFirst{0}, kSecond{1};

TEST(FramePool, SlotsArePageAlignedWithPaddedRows) {
  const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
  for (const FrameSize size :
       {FrameSize{1, 1}, FrameSize{641, 479}, FrameSize{1280, 800}, FrameSize{4096, 3072}}) {
    FramePool pool({size, {16, 8}}, 2);
    std::vector<Frame> held;
    while (auto frame = pool.take(kFirst)) held.push_back(std::move(*frame));
    ASSERT_EQ(held.size(), 2U);
    const auto slab = pool.memory();
    for (Frame& frame : held) {
      const gpu::ImageView image = frame.image();
      EXPECT_EQ(image.width_px, size.width_px);
      EXPECT_EQ(image.height_px, size.height_px);
      EXPECT_EQ(image.stride_bytes % 16, 0U);
      EXPECT_GE(image.stride_bytes, size.width_px);
      EXPECT_LT(image.stride_bytes, size.width_px + 16);
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(image.pixels) % page, 0U);
      EXPECT_EQ(frame.pixels().size(), std::size_t{image.stride_bytes} * size.height_px);
      // The padding rows belong to the slot as well.
      const std::size_t padded_rows = (std::size_t{size.height_px} + 7) / 8 * 8;
      const auto* const end =
          reinterpret_cast<const std::byte*>(image.pixels) + padded_rows * image.stride_bytes;
      EXPECT_LE(end, slab.data() + slab.size());
    }
    const auto distance = std::abs(held[0].image().pixels - held[1].image().pixels);
    EXPECT_GE(static_cast<std::size_t>(distance),
              (std::size_t{size.height_px} + 7) / 8 * 8 * held[0].stride_bytes());
  }
}

TEST(FramePool, SlotsDoNotOverlap) {
  FramePool pool({{33, 17}, {64, 3}, {5, 40}}, 3);
  std::vector<Frame> held;
  for (std::uint8_t camera = 0; camera < 3; ++camera) {
    while (auto frame = pool.take(CameraId{camera})) {
      std::ranges::fill(frame->pixels(), static_cast<std::uint8_t>(held.size()));
      EXPECT_EQ(frame->camera, CameraId{camera});
      held.push_back(std::move(*frame));
    }
  }
  ASSERT_EQ(held.size(), 9U);
  for (std::size_t n = 0; n < held.size(); ++n) {
    for (const std::uint8_t pixel : held[n].pixels()) ASSERT_EQ(pixel, n);
  }
}

TEST(FramePool, LendsEachSlotOnceAndTakesItBack) {
  FramePool pool({{8, 8}, {8, 8}}, 2);
  std::optional<Frame> a = pool.take(kFirst), b = pool.take(kFirst);
  ASSERT_TRUE(a && b);
  EXPECT_FALSE(pool.take(kFirst));
  EXPECT_TRUE(pool.take(kSecond));  // the other camera has its own
  const std::uint8_t* const pixels = a->image().pixels;
  a.reset();
  std::optional<Frame> again = pool.take(kFirst);
  ASSERT_TRUE(again);
  EXPECT_EQ(again->image().pixels, pixels);
}

TEST(Frame, MovesTheSlotAndWhatIsKnownOfIt) {
  FramePool pool({{8, 8}}, 1);
  Frame a = std::move(*pool.take(kFirst));
  a.sequence = 7;
  a.damaged = true;
  a.stamp = StampPoint::EndOfFrame;
  const std::uint8_t* const pixels = a.image().pixels;
  Frame b(std::move(a));
  EXPECT_EQ(b.image().pixels, pixels);
  EXPECT_EQ(b.sequence, 7U);
  EXPECT_TRUE(b.damaged);
  EXPECT_EQ(b.stamp, StampPoint::EndOfFrame);
  EXPECT_EQ(a.image().pixels, nullptr);  // NOLINT(bugprone-use-after-move): empty is what is promised
  EXPECT_TRUE(a.pixels().empty());
  EXPECT_FALSE(pool.take(kFirst));
  Frame& same = b;
  b = std::move(same);
  EXPECT_EQ(b.image().pixels, pixels);
  b = Frame();
  EXPECT_TRUE(pool.take(kFirst));
}

TEST(Frame, AssigningReturnsTheOldSlot) {
  FramePool pool({{8, 8}}, 2);
  Frame a = std::move(*pool.take(kFirst));
  a = std::move(*pool.take(kFirst));
  EXPECT_TRUE(pool.take(kFirst));
}

TEST(FramePool, RefusesSizesThatItCannotServe) {
  EXPECT_THROW(FramePool({}, 1), Error);
  EXPECT_THROW(FramePool({{0, 8}}, 1), Error);
  EXPECT_THROW(FramePool({{8, 0}}, 1), Error);
  EXPECT_THROW(FramePool({{8192, 4096}}, 1), Error);
  EXPECT_THROW(FramePool(std::vector<FrameSize>(33, FrameSize{8, 8}), 1), Error);
}

TEST(FramePool, SaysSoWhenTheMemoryIsNotToBeHad) {
  // 32 cameras x 16 MiB x 2^20 slots is beyond the address space, 2^31 beyond counting.
  const std::vector<FrameSize> cameras(32, FrameSize{4096, 4096});
  EXPECT_THROW(FramePool(cameras, 1U << 20U), Error);
  EXPECT_THROW(FramePool(cameras, 1U << 31U), Error);
}

TEST(FramePoolDeathTest, AFrameMayNotOutliveItsPool) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(
      {
        std::optional<Frame> frame;
        FramePool pool({{8, 8}}, 1);
        frame = pool.take(kFirst);
      },
      "bug");
}

// One thread takes and writes, another checks and returns. A slot that came back too early would show a wrong
// pattern, and a race shows under the thread sanitizer.
TEST(FramePool, FramesMayBeReturnedByAnotherThread) {
  constexpr std::uint32_t kFrames = 20'000;
  FramePool pool({{64, 16}}, 3);
  Ring<Frame> ring(2);
  std::jthread taker([&] {
    for (std::uint32_t n = 0; n < kFrames;) {
      std::optional<Frame> frame = pool.take(kFirst);
      if (!frame) {
        std::this_thread::yield();
        continue;
      }
      frame->sequence = n;
      std::memset(frame->pixels().data(), static_cast<int>(n % 251), frame->pixels().size());
      if (!ring.wait_push(std::move(*frame))) break;
      ++n;
    }
    ring.close();
  });
  std::uint32_t expected = 0;
  for (Frame frame; ring.wait_pop(frame); ++expected) {
    ASSERT_EQ(frame.sequence, expected);
    for (const std::uint8_t pixel : frame.pixels()) ASSERT_EQ(pixel, expected % 251);
  }
  EXPECT_EQ(expected, kFrames);
}

}  // namespace
}  // namespace glint
