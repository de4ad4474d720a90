// SPDX-License-Identifier: MIT
// The cameras of this computer: what there is, and opening the one that is meant.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/base/error.hpp"
#include "host/capture/v4l2/camera_controls.hpp"
#include "host/capture/v4l2/camera_formats.hpp"
#include "host/capture/v4l2/device_calls.hpp"
#include "host/capture/v4l2/device_identity.hpp"

namespace glint {

struct CameraInfo {
  DeviceIdentity identity;
  std::string card, driver, bus_info;
  std::vector<FormatOffer> formats;
  std::vector<CameraControl> controls;
  std::vector<std::string> bus_neighbours;  ///< nodes of other cameras on the same USB bus
  std::string problem;  ///< why nothing more is known than its identity; "" if all is well
};

struct CameraList {
  std::vector<CameraInfo> cameras;
  std::string problem;  ///< why there is none; "" if there are some
};

/// Every node that can capture, and those that may not be opened.
CameraList list_cameras(DeviceCalls& calls, const DeviceRoots& roots = {});

/// Nothing like it is connected.
class NoSuchCamera : public Error {
  using Error::Error;
};

/// An open camera, which can capture and stream.
struct OpenCamera {
  DeviceIdentity identity;
  DeviceNode node;
};

/// `device`: see means(); a path may also lie outside of `roots`. Throws NoSuchCamera, or Error: more than
/// one such camera, no permission, no camera but something else.
OpenCamera open_camera(DeviceCalls& calls, const DeviceRoots& roots, std::string_view device);

}  // namespace glint
