// SPDX-License-Identifier: MIT
// A tree of devices as Linux shows it, in a temporary folder.
#pragma once

#include <filesystem>
#include <string>

#include "host/capture/v4l2/device_identity.hpp"
#include "tests/support/temp_dir.hpp"

namespace glint::test {

class FakeSysfs {
 public:
  FakeSysfs() {
    std::filesystem::create_directories(root() / "sys/class/video4linux");
    std::filesystem::create_directories(root() / "dev");
  }
  DeviceRoots roots() const { return {root() / "dev", root() / "sys"}; }
  std::string node(unsigned number) const { return (root() / "dev" / name(number)).string(); }

  /// A USB camera: picture node and, behind it, a metadata node.
  void add_usb(unsigned number, const std::string& port, const std::string& serial, bool metadata = false) {
    const std::string bus = port.substr(0, port.find('-'));
    const std::string controller = "sys/devices/pci0000:00/0000:00:14.0";
    const std::string usb = controller + "/usb" + bus + "/" + port;
    const std::string interface = usb + "/" + port + ":1.0";
    temp_.write(usb + "/busnum", bus + "\n");
    temp_.write(usb + "/speed", "480\n");
    if (!serial.empty()) temp_.write(usb + "/serial", serial + "\n");
    subsystem(controller, "pci");
    subsystem(controller + "/usb" + bus, "usb");
    subsystem(usb, "usb");
    subsystem(interface, "usb");
    add_node(number, interface, 0);
    if (metadata) add_node(number + 1, interface, 1);
  }
  void add_platform(unsigned number, const std::string& device, unsigned index) {
    subsystem("sys/devices/platform/" + device, "platform");
    add_node(number, "sys/devices/platform/" + device, index);
  }
  /// A node of no device, as v4l2loopback makes them.
  void add_virtual(unsigned number) {
    const std::string folder = "sys/devices/virtual/video4linux/" + name(number);
    temp_.write(folder + "/index", "0\n");
    temp_.write("dev/" + name(number), "");
    link(root() / folder, "sys/class/video4linux/" + name(number));
  }
  void remove(unsigned number) {
    std::filesystem::remove(root() / "sys/class/video4linux" / name(number));
    std::filesystem::remove(root() / "dev" / name(number));
  }
  void link_by_path(const std::string& link_name, unsigned number) {
    link("../../" + name(number), "dev/v4l/by-path/" + link_name);
  }

 private:
  static std::string name(unsigned number) { return "video" + std::to_string(number); }
  std::filesystem::path root() const { return temp_.path(); }
  void link(const std::filesystem::path& target, const std::string& at) {
    std::filesystem::create_directories((root() / at).parent_path());
    std::filesystem::remove(root() / at);
    std::filesystem::create_symlink(target, root() / at);
  }
  void subsystem(const std::string& device, const std::string& kind) {
    std::filesystem::create_directories(root() / "sys/bus" / kind);
    link(root() / "sys/bus" / kind, device + "/subsystem");
  }
  void add_node(unsigned number, const std::string& device, unsigned index) {
    const std::string folder = device + "/video4linux/" + name(number);
    temp_.write(folder + "/index", std::to_string(index) + "\n");
    temp_.write("dev/" + name(number), "");
    link(root() / device, folder + "/device");
    link(root() / folder, "sys/class/video4linux/" + name(number));
  }

  TempDir temp_;
};

}  // namespace glint::test
