// SPDX-License-Identifier: MIT
// An eventfd.
#include "host/capture/v4l2/wake_up.hpp"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <string>

#include "host/base/error.hpp"

namespace glint {

WakeUp::WakeUp() : descriptor_(eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {
  if (descriptor_ < 0) throw Error(std::string("no eventfd: ") + std::strerror(errno));
}

WakeUp::~WakeUp() { close(descriptor_); }

void WakeUp::wake() noexcept {
  const std::uint64_t one = 1;
  // It fails only when it is full of calls already.
  [[maybe_unused]] const ssize_t written = write(descriptor_, &one, sizeof one);
}

void WakeUp::wait_until(Timestamp until) noexcept {
  const auto left = std::max(until - std::chrono::steady_clock::now(), std::chrono::nanoseconds{0});
  const timespec timeout{static_cast<time_t>(left.count() / 1'000'000'000),
                         static_cast<long>(left.count() % 1'000'000'000)};
  pollfd wanted{descriptor_, POLLIN, 0};
  if (ppoll(&wanted, 1, &timeout, nullptr) <= 0) return;
  std::uint64_t calls = 0;
  [[maybe_unused]] const ssize_t taken = read(descriptor_, &calls, sizeof calls);
}

}  // namespace glint
