// SPDX-License-Identifier: MIT
// USB cameras in a tree of devices, with a driver that answers for them.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "host/capture/v4l2/camera_list.hpp"
#include "host/capture/v4l2/camera_stream.hpp"
#include "tests/unit/capture/fake_sysfs.hpp"
#include "tests/unit/capture/fake_v4l2.hpp"

namespace glint::test {

class FakeRig {
 public:
  /// A camera on that port with GREY and MJPG in 1280x800, at 10 and 90 Hz.
  FakeCamera& add(unsigned number, const std::string& port, bool metadata = false) {
    tree_.add_usb(number, port, "", metadata);
    FakeCamera& camera = driver_.add(tree_.node(number));
    camera.formats = {{V4L2_PIX_FMT_GREY, {FakeSize{1280, 800, {10.0}}}},
                      {V4L2_PIX_FMT_MJPEG, {FakeSize{1280, 800, {90.0, 60.0}}}}};
    return camera;
  }
  CameraRequest request(const std::string& port, std::optional<PixelKind> kind, double rate_hz) const {
    CameraRequest request;
    request.name = "on " + port;
    request.device = "usb:" + port;
    request.format = {kind, {1280, 800}, rate_hz};
    return request;
  }
  CameraList list() { return list_cameras(driver_, tree_.roots()); }

  FakeSysfs tree_;
  FakeV4l2 driver_;
};

}  // namespace glint::test
