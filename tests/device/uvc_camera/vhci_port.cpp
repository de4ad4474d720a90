// SPDX-License-Identifier: MIT
// Files below /sys/devices/platform/vhci_hcd.0.
#include "tests/device/uvc_camera/vhci_port.hpp"

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "host/base/error.hpp"

namespace glint::device {
namespace {

namespace fs = std::filesystem;

const fs::path kController = "/sys/devices/platform/vhci_hcd.0";

std::string first_word(const fs::path& path) {
  std::ifstream file(path);
  std::string word;
  file >> word;
  return word;
}

/// Child folders whose name ends so; none where the folder is not there or goes away meanwhile.
std::vector<fs::path> children(const fs::path& folder, const std::string& begin, const std::string& end) {
  std::vector<fs::path> found;
  std::error_code gone;
  for (fs::directory_iterator at(folder, gone), none; !gone && at != none; at.increment(gone)) {
    const std::string name = at->path().filename().string();
    if (name.size() >= begin.size() + end.size() && name.compare(0, begin.size(), begin) == 0 &&
        name.compare(name.size() - end.size(), end.size(), end) == 0)
      found.push_back(at->path());
  }
  return found;
}

}  // namespace

VhciPort::VhciPort(unsigned number) : number_(number) {
  if (!fs::exists(kController / "attach"))
    throw Error(kController.string() + ": is not there; load the kernel module vhci-hcd");
}

bool VhciPort::free() const {
  constexpr unsigned kNothingAttached = 4;
  std::ifstream file(kController / "status");
  std::string line;
  std::getline(file, line);  // names of the columns
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string hub;
    unsigned port = 0, status = 0;
    words >> hub >> port >> status;
    if (hub == "hs" && port == number_) return status == kNothingAttached;
  }
  throw Error(kController.string() + ": has no high-speed port " + std::to_string(number_));
}

void VhciPort::attach(int socket, UsbSpeed speed) const {
  std::ofstream file(kController / "attach");
  file << number_ << ' ' << socket << ' ' << number_ + 1 << ' ' << static_cast<unsigned>(speed) << std::flush;
  if (!file) throw Error("virtual USB port " + std::to_string(number_) + ": refuses the device");
}

void VhciPort::detach() const noexcept {
  if (std::FILE* file = std::fopen((kController / "detach").c_str(), "w")) {
    std::fprintf(file, "%u", number_);
    std::fclose(file);
  }
}

std::string VhciPort::capture_node() const {
  const std::string end = "-" + std::to_string(number_ + 1);
  for (const fs::path& bus : children(kController, "usb", "")) {
    if (first_word(bus / "speed") != "480") continue;
    for (const fs::path& camera : children(bus, "", end)) {
      for (const fs::path& interface : children(camera, "", ":1.0")) {
        for (const fs::path& node : children(interface / "video4linux", "video", "")) {
          if (first_word(node / "index") == "0") return "/dev/" + node.filename().string();
        }
      }
    }
  }
  return {};
}

}  // namespace glint::device
