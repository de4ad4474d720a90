// SPDX-License-Identifier: MIT
// A USB camera at a virtual port: answers the host's requests and lets transfers complete when the bus would.
#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "tests/device/uvc_camera/control_pipe.hpp"
#include "tests/device/uvc_camera/descriptors.hpp"
#include "tests/device/uvc_camera/payload_stream.hpp"
#include "tests/device/uvc_camera/usbip_wire.hpp"
#include "tests/device/uvc_camera/vhci_port.hpp"

namespace glint::device {

/// Times are nanoseconds of CLOCK_MONOTONIC. Thread-bound.
class VirtualCamera {
 public:
  VirtualCamera(CameraModel model, unsigned port);
  ~VirtualCamera();
  VirtualCamera(const VirtualCamera&) = delete;
  VirtualCamera& operator=(const VirtualCamera&) = delete;

  /// Plugs the camera in, as it was when made. Throws Error.
  void plug();
  /// Pulls the cable, whatever is under way.
  void unplug() noexcept;
  bool plugged() const noexcept { return socket_ >= 0; }
  /// The port takes a camera.
  bool can_plug() const { return !plugged() && port_.free(); }
  std::string capture_node() const { return port_.capture_node(); }
  /// No transfer completes while it hangs.
  void hang(bool hangs) noexcept { hangs_ = hangs; }

  /// The host has chosen a format and started the stream.
  bool streaming() const noexcept { return plugged() && control_.alternate() != 0; }
  /// Hands a frame to the stream; what comes while the host does not stream is lost.
  void send(StreamFrame frame);

  int socket() const noexcept { return socket_; }
  /// Reads and answers what the host sent. False when the host let go of the camera.
  bool answer_host(std::int64_t now_ns);
  /// Completes the transfers that are due.
  void complete_due(std::int64_t now_ns);
  /// When the next transfer is due; the largest number if none is.
  std::int64_t next_due_ns() const noexcept;
  /// Transfers that came later than the bus needed them: the host could not keep up.
  std::uint64_t starved() const noexcept { return starved_; }

 private:
  void answer(UsbipRequest request, std::int64_t now_ns);
  void complete(const UsbipRequest& request);
  void reply(const std::vector<std::uint8_t>& bytes);

  CameraModel model_;
  VhciPort port_;
  ControlPipe control_;
  PayloadStream stream_;
  int socket_ = -1;
  bool hangs_ = false;
  std::vector<std::uint8_t> received_;
  std::deque<UsbipRequest> transfers_;  // isochronous, in the order of the bus
  std::int64_t bus_ns_ = 0;             // where the first of them begins
  bool bus_runs_ = false;
  std::vector<std::uint8_t> data_;
  std::uint64_t starved_ = 0;
};

}  // namespace glint::device
