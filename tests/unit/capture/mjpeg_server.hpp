// SPDX-License-Identifier: MIT
// A network camera on loopback: JPEG pictures over HTTP, as IP cameras send them.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <thread>
#include <vector>

namespace glint::test {

/// Serves one client after another, sending its pictures over and over.
class MjpegServer {
 public:
  struct Behaviour {
    std::chrono::milliseconds period{20};
    int frames = 1'000'000;  ///< then it goes quiet, or hangs up
    bool hang_up = false;
    bool silent = false;  ///< accepts and never answers
  };
  MjpegServer(std::vector<std::string> jpegs, const Behaviour& behaviour);
  ~MjpegServer();
  MjpegServer(const MjpegServer&) = delete;
  MjpegServer& operator=(const MjpegServer&) = delete;

  /// http://user:secret@127.0.0.1:PORT/stream
  std::string address() const;

 private:
  void serve(const std::stop_token& stop);
  void stream_to(int client, const std::stop_token& stop) const;
  std::vector<std::string> jpegs_;
  Behaviour behaviour_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::jthread thread_;
};

}  // namespace glint::test
