// SPDX-License-Identifier: MIT
// System calls on device nodes, and the descriptor that closes itself.
#include "host/capture/v4l2/device_calls.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace glint {
namespace {

template <typename Call>
int repeated(const Call& call) noexcept {
  for (;;) {
    const int result = call();
    if (result >= 0) return result;
    if (errno != EINTR) return -errno;
  }
}

}  // namespace

int KernelCalls::open(const char* path) noexcept {
  return repeated([&] { return ::open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC); });
}

void KernelCalls::close(int descriptor) noexcept { ::close(descriptor); }

int KernelCalls::ioctl(int descriptor, unsigned long request, void* argument) noexcept {
  return repeated([&] { return ::ioctl(descriptor, request, argument); });
}

std::byte* KernelCalls::map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept {
  // Some drivers refuse a mapping that cannot be written to.
  void* const memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, offset);
  return memory == MAP_FAILED ? nullptr : static_cast<std::byte*>(memory);
}

void KernelCalls::unmap(std::byte* memory, std::size_t bytes) noexcept { ::munmap(memory, bytes); }

int KernelCalls::poll(int descriptor, std::chrono::nanoseconds longest) noexcept {
  const Timestamp until = now() + longest;
  pollfd wanted{descriptor, POLLIN, 0};
  const int ready = repeated([&] {
    const auto left = std::max(until - now(), std::chrono::nanoseconds{0});
    const timespec timeout{static_cast<time_t>(left.count() / 1'000'000'000),
                           static_cast<long>(left.count() % 1'000'000'000)};
    return ::ppoll(&wanted, 1, &timeout, nullptr);
  });
  return ready > 0 ? wanted.revents : ready;
}

DeviceNode& DeviceNode::operator=(DeviceNode&& other) noexcept {
  if (this == &other) return *this;
  close();
  calls_ = other.calls_;
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

void DeviceNode::close() noexcept {
  if (descriptor_ >= 0) calls_->close(std::exchange(descriptor_, -1));
}

}  // namespace glint
