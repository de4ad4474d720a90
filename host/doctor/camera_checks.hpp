// SPDX-License-Identifier: MIT
// Is every camera there, may it be opened, and does it offer what the rig wants?
#pragma once

#include <optional>
#include <vector>

#include "host/capture/v4l2/camera_list.hpp"
#include "host/capture/v4l2/camera_stream.hpp"
#include "host/doctor/finding.hpp"

namespace glint {

/// Cameras and their permissions; one finding, or one for each that cannot be used. `list`: of list_cameras()
/// with the same roots.
Findings check_cameras(const CameraList& list, const DeviceRoots& roots);

/// The cameras of a rig: connected, with format, size, rate and controls that it wants. Opens them and
/// changes nothing. One finding each.
Findings check_wanted(DeviceCalls& calls, const DeviceRoots& roots, const std::vector<CameraRequest>& wanted);

/// The format that would be taken of those listed: the wanted one, or the first that fits of grey, nv12,
/// yuyv, mjpeg. Nothing: none fits.
std::optional<PixelKind> format_for(const std::vector<FormatOffer>& formats, const WantedFormat& wanted);

}  // namespace glint
