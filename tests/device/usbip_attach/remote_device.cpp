// SPDX-License-Identifier: MIT
// OP_REQ_IMPORT and its answer (Documentation/usb/usbip_protocol.rst of Linux); then the socket is the
// kernel's.
#include "tests/device/usbip_attach/remote_device.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "host/base/error.hpp"

namespace glint::device {
namespace {

constexpr std::size_t kAnswerBytes = 8 + 312, kStatusAt = 4, kSpeedAt = 8 + 296;
constexpr std::size_t kBusidBytes = 32;

std::uint32_t word_at(const std::vector<std::uint8_t>& bytes, std::size_t at) {
  return std::uint32_t{bytes[at]} << 24 | std::uint32_t{bytes[at + 1]} << 16 |
         std::uint32_t{bytes[at + 2]} << 8 | bytes[at + 3];
}

}  // namespace

RemoteDevice::RemoteDevice(Exporter exporter, std::string busid, unsigned port)
    : exporter_(std::move(exporter)), busid_(std::move(busid)), port_(port) {
  if (busid_.size() >= kBusidBytes) throw UsageError(busid_ + ": is longer than a bus id can be");
}

RemoteDevice::~RemoteDevice() {
  if (plugged_) port_.detach();
  close_socket();
}

void RemoteDevice::step() {
  if (socket_ < 0) {
    if (port_.free()) ask();
    return;
  }
  if (!plugged_) {
    if (!take_answer()) return;
    port_.attach(socket_, static_cast<UsbSpeed>(word_at(answer_, kSpeedAt)));
    plugged_ = true;
    return;
  }
  pollfd poll_for{socket_, POLLRDHUP, 0};
  if (poll(&poll_for, 1, 0) > 0 && (poll_for.revents & (POLLRDHUP | POLLHUP | POLLERR)) != 0) {
    plugged_ = false;
    close_socket();
  }
}

void RemoteDevice::ask() {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(exporter_.port);
  if (inet_pton(AF_INET, exporter_.host.c_str(), &address.sin_addr) != 1)
    throw UsageError(exporter_.host + ": is not an IPv4 address");
  socket_ = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
  const int at_once = 1;
  std::array<std::uint8_t, 8 + kBusidBytes> request{0x01, 0x11, 0x80, 0x03};
  std::copy(busid_.begin(), busid_.end(), request.begin() + 8);
  if (socket_ < 0 || setsockopt(socket_, IPPROTO_TCP, TCP_NODELAY, &at_once, sizeof at_once) != 0 ||
      connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 ||
      write(socket_, request.data(), request.size()) != static_cast<ssize_t>(request.size()))
    throw Error(exporter_.host + ":" + std::to_string(exporter_.port) + ": " + std::strerror(errno) +
                "; start usbip_server.js");
  answer_.clear();
}

/// True when the answer is whole; an exporter that has ended meanwhile is asked again.
bool RemoteDevice::take_answer() {
  std::array<std::uint8_t, kAnswerBytes> chunk;
  const ssize_t got = recv(socket_, chunk.data(), kAnswerBytes - answer_.size(), MSG_DONTWAIT);
  if (got < 0 && errno == EAGAIN) return false;
  if (got > 0) answer_.insert(answer_.end(), chunk.begin(), chunk.begin() + got);
  if (answer_.size() > kStatusAt + 3 && word_at(answer_, kStatusAt) != 0)
    throw Error(exporter_.host + ": exports no device " + busid_);
  if (got <= 0) close_socket();
  return answer_.size() == kAnswerBytes;
}

void RemoteDevice::close_socket() noexcept {
  if (socket_ >= 0) close(socket_);
  socket_ = -1;
}

}  // namespace glint::device
