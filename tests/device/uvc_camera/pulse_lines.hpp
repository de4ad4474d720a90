// SPDX-License-Identifier: MIT
// Pulses of a simulated sync board: edges at one of its pins, told by tests/board/usbip_server.js.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace glint::device {

/// A connection to the server's control port. Its lines come when they come; what counts is when the board
/// says that its pin rose, so the time of a pulse here is that, plus the shortest delay of any line so far.
class PulseLines {
 public:
  /// `place`: ADDRESS:PORT. Throws Error, UsageError.
  PulseLines(const std::string& place, unsigned pin);
  ~PulseLines();
  PulseLines(const PulseLines&) = delete;
  PulseLines& operator=(const PulseLines&) = delete;

  int socket() const noexcept { return socket_; }
  /// When the next pulse was, in this machine's monotonic nanoseconds; nothing if no line is whole. Throws
  /// Error when the server has ended.
  std::optional<std::int64_t> next(std::int64_t now_ns);

 private:
  int socket_ = -1;
  std::string read_;
  std::optional<std::int64_t> least_delay_ns_;  // between the board's clock and this one
};

}  // namespace glint::device
