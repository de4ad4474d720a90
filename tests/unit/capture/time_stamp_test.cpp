// SPDX-License-Identifier: MIT
// Drivers' time stamps, odd ones included.
#include "host/capture/v4l2/time_stamp.hpp"

#include <gtest/gtest.h>

namespace glint {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::seconds;

const Timestamp kNow(seconds(5000));

v4l2_buffer stamped(std::int64_t s, std::int64_t us, std::uint32_t flags) {
  v4l2_buffer buffer{};
  buffer.timestamp = {s, us};
  buffer.flags = flags;
  return buffer;
}

TEST(FrameTime, StartAndEnd) {
  const FrameTime start =
      time_of(stamped(4999, 990000, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE), kNow);
  EXPECT_EQ(start.stamped, kNow - milliseconds(10));
  EXPECT_EQ(start.point, StampPoint::StartOfExposure);
  const FrameTime end = time_of(stamped(4999, 999000, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC), kNow);
  EXPECT_EQ(end.stamped, kNow - milliseconds(1));
  EXPECT_EQ(end.point, StampPoint::EndOfFrame);
}

TEST(FrameTime, TheNearFutureIsBelieved) {
  const FrameTime time = time_of(stamped(5000, 29000, V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC), kNow);
  EXPECT_EQ(time.stamped, kNow + milliseconds(29));
  EXPECT_EQ(time.point, StampPoint::EndOfFrame);
}

TEST(FrameTime, OtherClocksAndNonsenseAreReplacedByTheArrival) {
  const std::uint32_t monotonic = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  for (const v4l2_buffer& odd :
       {stamped(4999, 0, V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN), stamped(4999, 0, V4L2_BUF_FLAG_TIMESTAMP_COPY),
        stamped(5002, 0, monotonic), stamped(4980, 0, monotonic), stamped(0, 0, monotonic),
        stamped(9223372036, 850000, monotonic), stamped(-9223372037, 160000, monotonic),
        stamped(INT64_MAX, 0, monotonic), stamped(INT64_MIN, 0, monotonic), stamped(4999, -1, monotonic),
        stamped(4999, 1000000, monotonic)}) {
    const FrameTime time = time_of(odd, kNow);
    EXPECT_EQ(time.stamped, kNow) << odd.timestamp.tv_sec;
    EXPECT_EQ(time.point, StampPoint::HostArrival);
  }
}

}  // namespace
}  // namespace glint
