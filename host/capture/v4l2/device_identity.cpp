// SPDX-License-Identifier: MIT
// Walks of sysfs.
#include "host/capture/v4l2/device_identity.hpp"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <system_error>

#include "host/capture/v4l2/camera_formats.hpp"

namespace glint {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kVideo = "video";

std::optional<unsigned> number_in(std::string_view text) {
  unsigned value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

std::string first_line(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

fs::path canonical_or_empty(const fs::path& path) {
  std::error_code error;
  fs::path real = fs::canonical(path, error);
  return error ? fs::path() : real;
}

std::string subsystem_of(const fs::path& device) {
  return canonical_or_empty(device / "subsystem").filename().string();
}

/// The nearest device above that does not belong to `subsystem` any more.
fs::path above(fs::path device, std::string_view subsystem) {
  while (device.has_relative_path() && subsystem_of(device) == subsystem) device = device.parent_path();
  return device;
}

UsbPlace usb_place(const fs::path& usb_device) {
  UsbPlace place;
  place.port = usb_device.filename().string();
  place.bus = number_in(first_line(usb_device / "busnum")).value_or(0);
  const std::string serial = first_line(usb_device / "serial");
  place.serial = driver_text(serial.data(), serial.size());    // the device's word, which a terminal may get
  const std::string speed = first_line(usb_device / "speed");  // "480", and "1.5" for the slowest
  double mbit_s = 0.0;
  if (std::from_chars(speed.data(), speed.data() + speed.size(), mbit_s).ec == std::errc{})
    place.speed_mbit_s = mbit_s;
  return place;
}

/// The names of the devices on the way up, as udev joins them: "pci-0000:00:14.0-usb-0:2.3:1.0".
void walk_up(fs::path device, const fs::path& top, DeviceIdentity& identity) {
  std::string path;
  const auto prepend = [&path](const std::string& part) { path = part + (path.empty() ? "" : "-" + path); };
  while (!device.empty() && device != top && device.has_relative_path()) {
    const std::string subsystem = subsystem_of(device), name = device.filename().string();
    if (subsystem == "usb") {
      const auto dash = name.find('-'), colon = name.find(':');  // the interface "1-2.3:1.0"
      if (dash != std::string::npos && colon != std::string::npos) {
        prepend("usb-0:" + name.substr(dash + 1));
        identity.usb = usb_place(device.parent_path());
      }
      device = above(device, "usb");
    } else if (subsystem == "pci" || subsystem == "platform") {
      prepend(subsystem + "-" + name);
      device = above(device, subsystem);
    } else {
      device = device.parent_path();
    }
  }
  if (!path.empty()) identity.by_path = path + "-video-index" + std::to_string(identity.index);
}

/// udev's own links have the last word.
void take_links(std::vector<DeviceIdentity>& identities, const DeviceRoots& roots) {
  std::error_code error;
  std::vector<fs::path> links;
  for (fs::directory_iterator it(roots.dev / "v4l" / "by-path", error), end; !error && it != end;
       it.increment(error)) {
    links.push_back(it->path());
  }
  std::sort(links.begin(), links.end());
  for (DeviceIdentity& identity : identities) {
    const fs::path node = canonical_or_empty(identity.node);
    std::string found;
    for (const fs::path& link : links) {
      if (node.empty() || canonical_or_empty(link) != node) continue;
      const std::string name = link.filename().string();
      if (found.empty() || name == identity.by_path) found = name;
    }
    if (!found.empty()) identity.by_path = found;
  }
}

/// A name that several nodes have (those of one vivid device) names none of them.
void drop_shared_names(std::vector<DeviceIdentity>& identities) {
  std::map<std::string, int> nodes;
  for (const DeviceIdentity& identity : identities) ++nodes[identity.by_path];
  for (DeviceIdentity& identity : identities) {
    if (nodes[identity.by_path] > 1) identity.by_path.clear();
  }
}

}  // namespace

std::vector<DeviceIdentity> list_identities(const DeviceRoots& roots) {
  std::vector<DeviceIdentity> all;
  std::error_code error;
  for (fs::directory_iterator it(roots.sys / "class" / "video4linux", error), end; !error && it != end;
       it.increment(error)) {
    const std::string name = it->path().filename().string();
    if (!name.starts_with(kVideo)) continue;
    const auto number = number_in(std::string_view(name).substr(kVideo.size()));
    if (!number) continue;
    DeviceIdentity identity;
    identity.node = (roots.dev / name).string();
    identity.number = *number;
    identity.index = number_in(first_line(it->path() / "index")).value_or(0);
    walk_up(canonical_or_empty(it->path() / "device"), canonical_or_empty(roots.sys), identity);
    all.push_back(std::move(identity));
  }
  std::sort(all.begin(), all.end(),
            [](const DeviceIdentity& a, const DeviceIdentity& b) { return a.number < b.number; });
  take_links(all, roots);
  drop_shared_names(all);
  return all;
}

bool means(std::string_view device, const DeviceIdentity& identity, const DeviceRoots& roots) {
  constexpr std::string_view kUsb = "usb:", kSerial = "serial:";
  if (device.empty()) return false;
  if (device.starts_with(kUsb)) return identity.usb && identity.usb->port == device.substr(kUsb.size());
  if (device.starts_with(kSerial)) {
    return identity.usb && !identity.usb->serial.empty() &&
           identity.usb->serial == device.substr(kSerial.size());
  }
  if (device == identity.node || device == identity.by_path) return true;
  if (!identity.by_path.empty() && fs::path(device) == roots.dev / "v4l" / "by-path" / identity.by_path)
    return true;
  if (!device.starts_with('/')) return false;
  const fs::path real = canonical_or_empty(device);  // any other link to the node
  return !real.empty() && real == canonical_or_empty(identity.node);
}

}  // namespace glint
