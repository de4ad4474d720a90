// SPDX-License-Identifier: MIT
// Frames in payloads, put together again as a driver does it.
#include "tests/device/uvc_camera/payload_stream.hpp"

#include <gtest/gtest.h>

#include <array>
#include <numeric>

namespace glint::device {
namespace {

constexpr std::int64_t kMicroframe_ns = 125'000;
constexpr std::size_t kRoom = 64;

struct Received {
  std::vector<std::uint8_t> bytes;
  unsigned frame_bit = 0;
  bool error = false, failed = false;
  std::int64_t first_ns = 0;
  unsigned packets = 0;
};

/// Frames that end within so many microframes.
std::vector<Received> receive(PayloadStream& stream, unsigned microframes, std::int64_t from_ns = 0) {
  std::vector<Received> frames;
  Received now;
  for (unsigned i = 0; i < microframes; ++i) {
    std::array<std::uint8_t, kRoom> room{};
    const std::int64_t time_ns = from_ns + i * kMicroframe_ns;
    const PayloadStream::Packet packet = stream.next(time_ns, room);
    if (packet.bytes == 0) continue;
    EXPECT_EQ(room[0], PayloadStream::kHeaderBytes);
    if (now.packets == 0) {
      now.first_ns = time_ns;
      now.frame_bit = room[1] & 1u;
    }
    EXPECT_EQ(now.frame_bit, room[1] & 1u) << "the frame bit changes within a frame";
    ++now.packets;
    now.error |= (room[1] & 0x40u) != 0;
    now.failed |= packet.failed;
    now.bytes.insert(now.bytes.end(), room.begin() + PayloadStream::kHeaderBytes,
                     room.begin() + static_cast<std::ptrdiff_t>(packet.bytes));
    if ((room[1] & 2u) != 0) {
      frames.push_back(now);
      now = {};
    }
  }
  return frames;
}

StreamFrame frame_of(std::size_t bytes, std::int64_t ready_ns = 0) {
  StreamFrame frame;
  frame.bytes.resize(bytes);
  std::iota(frame.bytes.begin(), frame.bytes.end(), std::uint8_t{1});
  frame.ready_ns = ready_ns;
  return frame;
}

TEST(PayloadStream, FramesComeOutAsTheyWentIn) {
  PayloadStream stream;
  for (const std::size_t bytes : {1u, 61u, 62u, 63u, 124u, 1000u}) stream.push(frame_of(bytes));
  const std::vector<Received> frames = receive(stream, 100);
  ASSERT_EQ(frames.size(), 6u);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::size_t bytes = std::array{1u, 61u, 62u, 63u, 124u, 1000u}[i];
    EXPECT_EQ(frames[i].bytes, frame_of(bytes).bytes);
    EXPECT_EQ(frames[i].packets, (bytes + kRoom - 3) / (kRoom - 2));
    EXPECT_EQ(frames[i].frame_bit, (i + 1) % 2) << "the frame bit tells frames apart";
    EXPECT_FALSE(frames[i].error);
  }
  EXPECT_TRUE(stream.empty());
}

TEST(PayloadStream, NothingLeavesBeforeItIsReady) {
  PayloadStream stream;
  stream.push(frame_of(100, 10 * kMicroframe_ns));
  const std::vector<Received> frames = receive(stream, 20);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].first_ns, 10 * kMicroframe_ns);
}

TEST(PayloadStream, ALateFrameHoldsUpTheNext) {
  PayloadStream stream;
  stream.push(frame_of(10, 8 * kMicroframe_ns));
  stream.push(frame_of(20, 4 * kMicroframe_ns));
  const std::vector<Received> frames = receive(stream, 20);
  ASSERT_EQ(frames.size(), 2u);
  EXPECT_EQ(frames[0].bytes.size(), 10u);
  EXPECT_EQ(frames[1].first_ns, 9 * kMicroframe_ns);
}

TEST(PayloadStream, FaultsStayWithTheirFrame) {
  PayloadStream stream;
  StreamFrame error = frame_of(200), toggle = frame_of(200), broken = frame_of(200);
  error.error_bit = true;
  toggle.same_toggle = true;
  broken.broken_packet = true;
  for (const StreamFrame& frame : {frame_of(200), error, toggle, broken, frame_of(200)}) stream.push(frame);
  const std::vector<Received> frames = receive(stream, 100);
  ASSERT_EQ(frames.size(), 5u);
  const std::array<unsigned, 5> frame_bits{1, 0, 0, 1, 0};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(frames[i].error, i == 1) << i;
    EXPECT_EQ(frames[i].failed, i == 3) << i;
    EXPECT_EQ(frames[i].frame_bit, frame_bits[i]) << i;
  }
}

TEST(PayloadStream, ResetForgetsWhatWasUnderWay) {
  PayloadStream stream;
  stream.push(frame_of(1000));
  EXPECT_TRUE(receive(stream, 3).empty());
  stream.reset();
  stream.push(frame_of(30));
  const std::vector<Received> frames = receive(stream, 3);
  ASSERT_EQ(frames.size(), 1u);
  EXPECT_EQ(frames[0].bytes, frame_of(30).bytes);
}

}  // namespace
}  // namespace glint::device
