// SPDX-License-Identifier: MIT
// A machine with HID devices that are not there: the kernel's files and calls are those of umockdev.
#pragma once

#include <umockdev.h>

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace glint::testing {

/// Devices at /dev/hidraw0, 1 and so on. umockdev must be preloaded: see available().
class MockedMachine {
 public:
  struct Device {
    std::string serial, product;
    std::string product_id = "0001";
    std::string usage_page = "00ff";
  };
  using Bytes = std::span<std::uint8_t>;

  MockedMachine();
  ~MockedMachine();
  MockedMachine(const MockedMachine&) = delete;
  MockedMachine& operator=(const MockedMachine&) = delete;

  static bool available();

  void plug(int number, const Device& device);
  /// Feature reports fail from now on, of all devices.
  void unplug(int number);
  /// One at a time: the next when the program has read it.
  void send(int number, std::span<const std::uint8_t> report);

  /// Feature reports that are asked for (the length of the answer) and set (0 or -1). Called by another
  /// thread.
  std::function<int(Bytes)> on_get = [](Bytes) { return -1; };
  std::function<int(Bytes)> on_set = [](Bytes) { return -1; };

 private:
  static gboolean answer(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer machine);
  static std::string node(int number) { return "/dev/hidraw" + std::to_string(number); }
  static std::string usb_path(int number);

  UMockdevTestbed* testbed_;
  UMockdevIoctlBase* handler_;
};

}  // namespace glint::testing
