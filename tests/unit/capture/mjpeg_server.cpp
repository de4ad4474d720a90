// SPDX-License-Identifier: MIT
// Plain sockets on 127.0.0.1, port chosen by the system.
#include "tests/unit/capture/mjpeg_server.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <stdexcept>

namespace glint::test {
namespace {

constexpr int kPollMs = 20;

bool readable(int socket) {
  pollfd waiting{socket, POLLIN, 0};
  return poll(&waiting, 1, kPollMs) > 0;
}

bool send_all(int socket, const std::string& bytes) {
  for (std::size_t sent = 0; sent < bytes.size();) {
    const ssize_t now = send(socket, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
    if (now <= 0) return false;
    sent += static_cast<std::size_t>(now);
  }
  return true;
}

}  // namespace

MjpegServer::MjpegServer(std::vector<std::string> jpegs, const Behaviour& behaviour)
    : jpegs_(std::move(jpegs)),
      behaviour_(behaviour),
      listener_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof at;
  auto* const generic = reinterpret_cast<sockaddr*>(&at);
  if (listener_ < 0 || bind(listener_, generic, length) != 0 || listen(listener_, 4) != 0 ||
      getsockname(listener_, generic, &length) != 0) {
    throw std::runtime_error("fixture: no loopback socket");
  }
  port_ = ntohs(at.sin_port);
  thread_ = std::jthread([this](const std::stop_token& stop) { serve(stop); });
}

MjpegServer::~MjpegServer() {
  thread_.request_stop();
  thread_.join();
  close(listener_);
}

std::string MjpegServer::address() const {
  return "http://user:secret@127.0.0.1:" + std::to_string(port_) + "/stream";
}

void MjpegServer::serve(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    if (!readable(listener_)) continue;
    const int client = accept(listener_, nullptr, nullptr);
    if (client < 0) continue;
    stream_to(client, stop);
    close(client);
  }
}

void MjpegServer::stream_to(int client, const std::stop_token& stop) const {
  std::string request;
  std::array<char, 1024> buffer{};
  while (request.find("\r\n\r\n") == std::string::npos && !stop.stop_requested()) {
    if (!readable(client)) continue;
    const ssize_t got = recv(client, buffer.data(), buffer.size(), 0);
    if (got <= 0) return;
    request.append(buffer.data(), static_cast<std::size_t>(got));
  }
  if (!behaviour_.silent) {
    if (!send_all(client,
                  "HTTP/1.0 200 OK\r\nContent-Type: multipart/x-mixed-replace;boundary=frame\r\n\r\n")) {
      return;
    }
    for (int n = 0; n < behaviour_.frames && !stop.stop_requested(); ++n) {
      const std::string& jpeg = jpegs_[static_cast<std::size_t>(n) % jpegs_.size()];
      if (!send_all(client, "--frame\r\nContent-Type: image/jpeg\r\nContent-Length: " +
                                std::to_string(jpeg.size()) + "\r\n\r\n" + jpeg + "\r\n")) {
        return;
      }
      std::this_thread::sleep_for(behaviour_.period);
    }
    if (behaviour_.hang_up) return;
  }
  // Quiet, until the client goes.
  while (!stop.stop_requested()) {
    if (readable(client) && recv(client, buffer.data(), buffer.size(), 0) <= 0) return;
  }
}

}  // namespace glint::test
