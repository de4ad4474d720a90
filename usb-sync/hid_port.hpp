// SPDX-License-Identifier: MIT
// The few calls that reach a board, behind an interface: tests answer them with a board of their own.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace glint::sync {

/// A board that is plugged in; it may not be one that can be opened.
struct FoundBoard {
  std::string path;    ///< what to open: "/dev/hidraw3"
  std::string serial;  ///< "" if it may not be read
};

/// An open HID device. One thread. Reports carry their id in the first byte.
class HidPort {
 public:
  virtual ~HidPort() = default;
  /// Waits for an input report. Its length (of an overlong one at least into.size()), 0 when the time is
  /// over, negative if the device is gone.
  virtual int read(std::span<std::uint8_t> into, std::chrono::milliseconds longest) noexcept = 0;
  /// report[0] says which one. Its length, or negative. A device that hangs is waited for as long as the
  /// kernel does: 5 s.
  virtual int get_feature(std::span<std::uint8_t> report) noexcept = 0;
  /// False if it was refused or the device is gone.
  virtual bool set_feature(std::span<const std::uint8_t> report) noexcept = 0;
};

/// Where boards are found. One thread at a time.
class HidBus {
 public:
  virtual ~HidBus() = default;
  /// Boards by vendor and product id, in the order of their serial numbers.
  virtual std::vector<FoundBoard> boards() = 0;
  /// Throws Error: gone meanwhile, or no permission and which udev rule gives it.
  virtual std::unique_ptr<HidPort> open(const FoundBoard& board) = 0;
};

/// The machine's own, by hidapi.
HidBus& machine_hid_bus();

}  // namespace glint::sync
