// SPDX-License-Identifier: MIT
// One high-speed port of the kernel's virtual USB host controller (vhci-hcd).
#pragma once

#include <string>

namespace glint::device {

/// As the kernel numbers them.
enum class UsbSpeed : unsigned { Full = 2, High = 3 };

class VhciPort {
 public:
  /// `number` counts the high-speed ports from 0. Throws Error when the kernel has no vhci-hcd.
  explicit VhciPort(unsigned number);

  /// Nothing is plugged in, and the kernel is done with what was.
  bool free() const;
  /// Plugs in the device at the other end of `socket`, which may be closed then. Throws Error.
  void attach(int socket, UsbSpeed speed = UsbSpeed::High) const;
  void detach() const noexcept;
  /// The capture node, such as /dev/video2, of the camera that is plugged in; empty while there is none.
  std::string capture_node() const;

 private:
  unsigned number_;
};

}  // namespace glint::device
