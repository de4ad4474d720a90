// SPDX-License-Identifier: MIT
// Nodes that are cameras.
#include "host/capture/v4l2/camera_list.hpp"

#include <linux/videodev2.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

namespace glint {
namespace {

std::string open_problem(int error) {
  if (error == EACCES || error == EPERM) {
    return "no permission to open it: add yourself to the group video (sudo usermod -aG video $USER) and log "
           "in again";
  }
  if (error == EBUSY) return "cannot be opened: another program uses it";
  return std::string("cannot be opened: ") + std::strerror(error);
}

std::optional<v4l2_capability> capability_of(DeviceNode& node) {
  v4l2_capability capability{};
  if (node.ioctl(VIDIOC_QUERYCAP, &capability) < 0) return std::nullopt;
  return capability;
}

std::uint32_t abilities(const v4l2_capability& capability) noexcept {
  return (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps
                                                               : capability.capabilities;
}

/// Why a node cannot be used as a camera; "" if it can.
std::string unfit(const std::optional<v4l2_capability>& capability) {
  if (!capability) return "is no video device";
  const std::uint32_t able = abilities(*capability);
  if ((able & V4L2_CAP_VIDEO_CAPTURE) == 0) {
    return (able & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0
               ? "gives pictures in several planes only, which glint does not read"
               : "gives no pictures";
  }
  return (able & V4L2_CAP_STREAMING) == 0 ? "cannot stream" : "";
}

bool same_bus(const CameraInfo& a, const CameraInfo& b) {
  return a.identity.usb && b.identity.usb && a.identity.usb->bus == b.identity.usb->bus;
}

void find_neighbours(std::vector<CameraInfo>& cameras) {
  for (CameraInfo& camera : cameras) {
    for (const CameraInfo& other : cameras) {
      if (&camera != &other && same_bus(camera, other)) camera.bus_neighbours.push_back(other.identity.node);
    }
  }
}

std::string connected_text(const std::vector<DeviceIdentity>& identities) {
  std::string text;
  for (const DeviceIdentity& identity : identities) {
    if (identity.index == 0) text += (text.empty() ? "" : ", ") + identity.stable_name();
  }
  return text.empty() ? "no camera is connected" : "connected are: " + text;
}

}  // namespace

CameraList list_cameras(DeviceCalls& calls, const DeviceRoots& roots) {
  CameraList list;
  for (DeviceIdentity& identity : list_identities(roots)) {
    CameraInfo camera;
    DeviceNode node(calls, identity.node.c_str());
    if (node.descriptor() < 0) {
      camera.problem = open_problem(-node.descriptor());
    } else {
      const std::optional<v4l2_capability> capability = capability_of(node);
      if (!unfit(capability).empty()) continue;
      camera.card = driver_text(capability->card, sizeof capability->card);
      camera.driver = driver_text(capability->driver, sizeof capability->driver);
      camera.bus_info = driver_text(capability->bus_info, sizeof capability->bus_info);
      camera.formats = list_formats(node);
      camera.controls = list_controls(node);
    }
    camera.identity = std::move(identity);
    list.cameras.push_back(std::move(camera));
  }
  find_neighbours(list.cameras);
  if (list.cameras.empty())
    list.problem = "no camera is connected (there is no /dev/video node that gives pictures)";
  return list;
}

OpenCamera open_camera(DeviceCalls& calls, const DeviceRoots& roots, std::string_view device) {
  const std::vector<DeviceIdentity> identities = list_identities(roots);
  std::vector<OpenCamera> found;
  std::string problem;
  const auto try_node = [&](const DeviceIdentity& identity) {
    DeviceNode node(calls, identity.node.c_str());
    const std::string why =
        node.descriptor() < 0 ? open_problem(-node.descriptor()) : unfit(capability_of(node));
    if (why.empty()) {
      found.push_back({identity, std::move(node)});
    } else if (problem.empty()) {
      problem = identity.node + ": " + why;
    }
  };
  bool any = false;
  for (const DeviceIdentity& identity : identities) {
    if (!means(device, identity, roots)) continue;
    any = true;
    try_node(identity);
  }
  std::error_code no_matter;
  if (!any && device.starts_with('/') && std::filesystem::exists(device, no_matter)) {
    DeviceIdentity identity;
    identity.node = std::string(device);
    try_node(identity);
  } else if (!any) {
    throw NoSuchCamera("\"" + std::string(device) + "\" is not there; " + connected_text(identities));
  }
  if (found.empty()) throw Error(problem);
  const auto same_device = [&](const OpenCamera& other) {
    const auto &a = found.front().identity.usb, &b = other.identity.usb;
    return a && b && a->port == b->port;
  };
  std::size_t best = 0;
  for (std::size_t n = 1; n < found.size(); ++n) {
    if (!same_device(found[n])) {
      throw Error("\"" + std::string(device) +
                  "\" is more than one camera: " + found[best].identity.stable_name() + " and " +
                  found[n].identity.stable_name() + "; use these names");
    }
    if (found[n].identity.index < found[best].identity.index) best = n;
  }
  return std::move(found[best]);
}

}  // namespace glint
