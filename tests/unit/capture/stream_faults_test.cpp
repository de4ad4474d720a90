// SPDX-License-Identifier: MIT
// One camera whose driver refuses, fails, falls silent or is unplugged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>

#include <cerrno>
#include <cstring>

#include "tests/unit/capture/camera_stream_fixture.hpp"

namespace glint {
namespace {

using std::chrono::milliseconds;
using test::error_of;
using ::testing::HasSubstr;

class StreamFaults : public ::testing::Test, protected test::StreamFixture {};

/// Four errors with four buffers: a stall for good, if nobody queues them again.
TEST_F(StreamFaults, RefusedBuffersAreQueuedAgain) {
  for (const bool in_place : {false, true}) {
    camera().takes_pointers = in_place;
    camera().most_buffers = 4;
    start();
    ASSERT_EQ(stream_->buffers(), 4u);
    for (int n = 0; n < 10; ++n) ASSERT_EQ(next_frame(), StreamStatus::Frame);
    camera().answers[VIDIOC_QBUF] = {EINVAL, EINVAL, EINVAL, EINVAL, EINVAL, EINVAL};
    for (int n = 0; n < 60; ++n) {
      ASSERT_EQ(next_frame(), StreamStatus::Frame) << n;
      ASSERT_EQ(received_.flaw, FrameFlaw::None);
    }
    EXPECT_TRUE(camera().answers[VIDIOC_QBUF].empty());
    EXPECT_EQ(camera().waiting.size() + camera().done.size(), 4u) << "a buffer is lost for ever";
  }
}

TEST_F(StreamFaults, BuffersThatAreNeverTakenAgainAreAFailure) {
  start();
  ASSERT_EQ(next_frame(), StreamStatus::Frame);
  for (int n = 0; n < 10000; ++n) camera().answers[VIDIOC_QBUF].push_back(EINVAL);
  StreamStatus status = StreamStatus::Nothing;
  int frames = 0;
  const Timestamp began = driver_.now();
  for (int n = 0; n < 1000 && status != StreamStatus::Broken; ++n) {
    status = next();
    if (status == StreamStatus::Frame) ++frames;
  }
  EXPECT_EQ(status, StreamStatus::Broken);
  EXPECT_LE(frames, 6);
  EXPECT_LT(driver_.now() - began, std::chrono::seconds(1));
  EXPECT_THAT(stream_->problem(), HasSubstr("takes no buffers"));
}

TEST_F(StreamFaults, Unplugged) {
  for (const bool in_place : {false, true}) {
    camera().takes_pointers = in_place;
    camera().plugged = true;
    start();
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    camera().plugged = false;
    const Timestamp pulled = driver_.now();
    EXPECT_EQ(next_frame(), StreamStatus::Unplugged);
    EXPECT_LT(driver_.now() - pulled, milliseconds(20));
    received_.frame = {};
    stream_.reset();
    pool_.reset();  // aborts if a slot were not given back
    EXPECT_EQ(driver_.open_nodes(), 0);
    EXPECT_EQ(driver_.mappings(), 0);
  }
}

TEST_F(StreamFaults, DriverErrorsEndTheStreamAndReopeningHelps) {
  for (const int error : {EIO, EINVAL, EPIPE}) {
    start();
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    camera().answers[VIDIOC_DQBUF] = {error};
    EXPECT_EQ(next_frame(), StreamStatus::Broken);
    EXPECT_THAT(stream_->problem(), HasSubstr(std::strerror(error)));
    start();
    EXPECT_EQ(next_frame(), StreamStatus::Frame);
  }
}

TEST_F(StreamFaults, PollThatOnlyReportsErrorsIsNotListenedToForEver) {
  start();
  ASSERT_EQ(next_frame(), StreamStatus::Frame);
  camera().hung = true;
  camera().done.clear();
  for (int n = 0; n < 1000; ++n) camera().answers[0].push_back(POLLERR);
  EXPECT_EQ(next_frame(), StreamStatus::Broken);
  EXPECT_GT(camera().answers[0].size(), 900u);
}

TEST_F(StreamFaults, SilenceIsNoticedAfterThreePeriodsAndEnds) {
  start();
  for (int n = 0; n < 5; ++n) ASSERT_EQ(next_frame(), StreamStatus::Frame);
  const Timestamp last = driver_.now();
  camera().hung = true;
  while (!stream_->silent()) ASSERT_EQ(next(), StreamStatus::Nothing);
  EXPECT_EQ(driver_.now() - last, milliseconds(30));
  for (int n = 0; n < 10; ++n) EXPECT_EQ(next(), StreamStatus::Nothing);
  EXPECT_TRUE(stream_->silent());
  camera().hung = false;
  EXPECT_EQ(next_frame(), StreamStatus::Frame);
  EXPECT_FALSE(stream_->silent());
}

TEST_F(StreamFaults, ASlowStartAndOurOwnPausesAreNoSilence) {
  camera().hung = true;
  start();
  for (int n = 0; n < 20; ++n) ASSERT_EQ(next(), StreamStatus::Nothing);
  EXPECT_FALSE(stream_->silent()) << "a second after the start";
  for (int n = 0; n < 50; ++n) ASSERT_EQ(next(), StreamStatus::Nothing);
  EXPECT_TRUE(stream_->silent()) << "three and a half";
  camera().hung = false;
  ASSERT_EQ(next_frame(), StreamStatus::Frame);
  driver_.with(path_, [](test::FakeCamera& c) { c.started -= milliseconds(500); });  // we slept
  ASSERT_EQ(next(), StreamStatus::Frame);
  EXPECT_FALSE(stream_->silent());
}

TEST_F(StreamFaults, WithoutAFreeSlotFramesAreDroppedNotOverwritten) {
  for (const bool in_place : {false, true}) {
    camera().takes_pointers = in_place;
    start(request(), in_place ? 6 + 2 : 2);
    std::vector<Frame> held;
    for (int n = 0; n < 2; ++n) {
      ASSERT_EQ(next_frame(), StreamStatus::Frame);
      ASSERT_EQ(received_.flaw, FrameFlaw::None);
      held.push_back(std::move(received_.frame));
    }
    for (int n = 0; n < 20; ++n) {
      ASSERT_EQ(next_frame(), StreamStatus::Frame);
      EXPECT_EQ(received_.flaw, FrameFlaw::NoSlot);
    }
    EXPECT_EQ(held[0].pixels()[0], 0);
    held.clear();
    ASSERT_EQ(next_frame(), StreamStatus::Frame);
    EXPECT_EQ(received_.flaw, FrameFlaw::None);
  }
}

TEST_F(StreamFaults, StartErrorsSayWhatToDo) {
  const struct {
    unsigned long call;
    int error;
    const char* text;
  } cases[] = {{VIDIOC_REQBUFS, EINVAL, "gives no buffers: Invalid argument"},
               {VIDIOC_QUERYBUF, EINVAL, "does not describe its buffers"},
               {VIDIOC_STREAMON, EINVAL, "cannot be started: Invalid argument"},
               {VIDIOC_STREAMON, ENOSPC, "the USB bus has no bandwidth left"}};
  for (const auto& [call, error, text] : cases) {
    camera().answers[call] = {error, error};  // asked for pointers first
    EXPECT_THAT(error_of([&] { start(); }), HasSubstr(text));
    camera().answers.clear();
    start();
    EXPECT_EQ(next_frame(), StreamStatus::Frame) << text;
  }
  camera().open_error = EACCES;
  EXPECT_THAT(error_of([&] { start(); }), HasSubstr("add yourself to the group video"));
  camera().open_error = 0;
  camera().abilities = V4L2_CAP_VIDEO_CAPTURE_MPLANE | V4L2_CAP_STREAMING;
  EXPECT_THAT(error_of([&] { start(); }), HasSubstr("several planes"));
}

TEST_F(StreamFaults, RefusedPointersFallBackToCopies) {
  camera().takes_pointers = true;
  camera().answers[VIDIOC_QBUF] = {EFAULT, EFAULT, EFAULT, EFAULT, EFAULT, EFAULT};
  start();
  EXPECT_FALSE(stream_->in_place());
  ASSERT_EQ(next_frame(), StreamStatus::Frame);
  EXPECT_EQ(received_.flaw, FrameFlaw::None);
  EXPECT_EQ(pixel(63, 47), 0);
}

}  // namespace
}  // namespace glint
