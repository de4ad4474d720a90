// SPDX-License-Identifier: MIT
// A device that another machine exports over USB/IP, at a port of the kernel's virtual host controller.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tests/device/uvc_camera/vhci_port.hpp"

namespace glint::device {

struct Exporter {
  std::string host;  ///< IPv4 address
  std::uint16_t port = 0;
};

/// Imports the device, plugs it in, and does so again whenever it has gone.
class RemoteDevice {
 public:
  /// `port`: number of the high-speed port of vhci-hcd. Throws Error where there is none.
  RemoteDevice(Exporter exporter, std::string busid, unsigned port);
  ~RemoteDevice();
  RemoteDevice(const RemoteDevice&) = delete;
  RemoteDevice& operator=(const RemoteDevice&) = delete;

  /// Does what can be done without waiting; call it when socket() is readable, and a few times a second.
  /// Throws Error when there is no exporter or it refuses.
  void step();
  /// To be polled for POLLIN and POLLRDHUP; -1: nothing to wait for but time.
  int socket() const noexcept { return socket_; }
  bool plugged() const noexcept { return plugged_; }

 private:
  void ask();
  bool take_answer();
  void close_socket() noexcept;

  Exporter exporter_;
  std::string busid_;
  VhciPort port_;
  int socket_ = -1;
  bool plugged_ = false;
  std::vector<std::uint8_t> answer_;
};

}  // namespace glint::device
