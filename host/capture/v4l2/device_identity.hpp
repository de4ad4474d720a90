// SPDX-License-Identifier: MIT
// Which camera is behind a /dev/video node: names that stay the same when numbers change, from sysfs alone.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace glint {

/// Where the system keeps its devices; tests have trees of their own.
struct DeviceRoots {
  std::filesystem::path dev = "/dev", sys = "/sys";
};

struct UsbPlace {
  std::string port;           ///< "1-2.3": bus 1, port 2 of the root hub, port 3 of the hub there
  unsigned bus = 0;           ///< cameras on the same bus share its bandwidth
  double speed_mbit_s = 0.0;  ///< 12, 480, 5000, ...; 0: unknown
  /// "" if it has none; many cheap cameras share one. What is not printable ASCII reads '?'.
  std::string serial;
};

struct DeviceIdentity {
  std::string node;     ///< /dev/video0
  unsigned number = 0;  ///< its 0
  unsigned index = 0;   ///< of the node among those of one device; 0 is the picture, others often metadata
  /// As udev names the link in /dev/v4l/by-path: that link where it is, else worked out in the same way.
  /// "" for devices that are nowhere (v4l2loopback) or share a name: their node is all there is.
  std::string by_path;
  std::optional<UsbPlace> usb;

  /// What to write into a rig file: by_path, else the node.
  const std::string& stable_name() const noexcept { return by_path.empty() ? node : by_path; }
};

/// All video4linux nodes, by number.
std::vector<DeviceIdentity> list_identities(const DeviceRoots& roots);

/// Whether `device`, as a person wrote it, means that node: its path, its name in /dev/v4l/by-path (with or
/// without the folder), "usb:PORT" or "serial:SERIAL".
bool means(std::string_view device, const DeviceIdentity& identity, const DeviceRoots& roots);

}  // namespace glint
