// SPDX-License-Identifier: MIT
#include "tests/device/uvc_camera/pulse_lines.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "host/base/error.hpp"

namespace glint::device {

PulseLines::PulseLines(const std::string& place, unsigned pin) {
  const std::size_t colon = place.find(':');
  sockaddr_in address{};
  std::uint16_t port = 0;
  if (colon == std::string::npos ||
      inet_pton(AF_INET, place.substr(0, colon).c_str(), &address.sin_addr) != 1 ||
      std::from_chars(place.data() + colon + 1, place.data() + place.size(), port).ec != std::errc{})
    throw UsageError(place + ": must be ADDRESS:PORT");
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  const std::string request = "stream " + std::to_string(pin) + "\n";
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int at_once = 1;
  if (socket_ < 0 || setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once) != 0 ||
      connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      write(socket_, request.data(), request.size()) != static_cast<ssize_t>(request.size())) {
    const std::string why = std::strerror(errno);
    if (socket_ >= 0) close(socket_);
    throw Error(place + ": " + why + "; start usbip_server.js");
  }
}

PulseLines::~PulseLines() { close(socket_); }

std::optional<std::int64_t> PulseLines::next(std::int64_t now_ns) {
  std::array<char, 4096> chunk;
  ssize_t got;
  while ((got = recv(socket_, chunk.data(), chunk.size(), MSG_DONTWAIT)) > 0)
    read_.append(chunk.data(), static_cast<std::size_t>(got));
  if (got == 0) throw Error("usbip_server.js has ended");
  for (std::size_t end; (end = read_.find('\n')) != std::string::npos;) {
    const std::string line = read_.substr(0, end);
    read_.erase(0, end + 1);
    constexpr std::string_view kRise = "rise ";
    if (!line.starts_with(kRise)) continue;
    std::int64_t board_ns = 0;
    std::from_chars(line.data() + kRise.size(), line.data() + line.size(), board_ns);
    least_delay_ns_ = std::min(least_delay_ns_.value_or(now_ns - board_ns), now_ns - board_ns);
    return board_ns + *least_delay_ns_;
  }
  return std::nullopt;
}

}  // namespace glint::device
