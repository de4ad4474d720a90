// SPDX-License-Identifier: MIT
// When a frame was taken, as far as the driver can be believed.
#pragma once

#include <linux/videodev2.h>

#include "host/base/ids.hpp"
#include "host/frames/frame_pool.hpp"

namespace glint {

struct FrameTime {
  Timestamp stamped{};
  StampPoint point = StampPoint::HostArrival;
};

/// The driver's stamp if it is of CLOCK_MONOTONIC and within reason: up to a second ahead of `arrived` (end
/// of frame is stamped ahead by some drivers) and ten behind. Else `arrived`, as HostArrival.
FrameTime time_of(const v4l2_buffer& buffer, Timestamp arrived) noexcept;

}  // namespace glint
