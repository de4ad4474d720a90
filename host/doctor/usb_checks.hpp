// SPDX-License-Identifier: MIT
// Will the pictures fit through the USB buses that the cameras share?
#pragma once

#include <vector>

#include "host/capture/v4l2/camera_list.hpp"
#include "host/capture/v4l2/camera_stream.hpp"
#include "host/doctor/finding.hpp"

namespace glint {

/// Bits a second that a camera sends in that format. MJPEG: what sharp pictures of a dark room with markers
/// have at quality 90, measured.
double stream_bit_s(PixelKind kind, FrameSize size, double rate_hz) noexcept;

/// One finding for each bus with a USB camera. `wanted`: the rig's cameras; without any only who shares a bus
/// is told. `roots`: to find which camera is meant.
Findings check_usb(const CameraList& list, const DeviceRoots& roots,
                   const std::vector<CameraRequest>& wanted);

}  // namespace glint
