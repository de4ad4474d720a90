// SPDX-License-Identifier: MIT
// From a v4l2_buffer's flags and timeval.
#include "host/capture/v4l2/time_stamp.hpp"

#include <chrono>

namespace glint {
namespace {

constexpr std::chrono::seconds kFarthestAhead{1}, kFarthestBehind{10};
constexpr std::int64_t kMost_s = 9'000'000'000;  // more overflows when counted in nanoseconds

}  // namespace

FrameTime time_of(const v4l2_buffer& buffer, Timestamp arrived) noexcept {
  const FrameTime by_arrival{arrived, StampPoint::HostArrival};
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return by_arrival;
  const std::int64_t seconds = buffer.timestamp.tv_sec, part_us = buffer.timestamp.tv_usec;
  if (seconds < 0 || seconds > kMost_s || part_us < 0 || part_us >= 1'000'000) return by_arrival;
  const Timestamp stamped(std::chrono::seconds(seconds) + std::chrono::microseconds(part_us));
  if (stamped > arrived + kFarthestAhead || stamped < arrived - kFarthestBehind) return by_arrival;
  const bool start = (buffer.flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  return {stamped, start ? StampPoint::StartOfExposure : StampPoint::EndOfFrame};
}

}  // namespace glint
