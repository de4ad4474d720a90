// SPDX-License-Identifier: MIT
// The system calls that capture makes on a camera's device node, behind an interface: tests answer them
// with a scripted driver.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "host/base/ids.hpp"

namespace glint {

/// Results as the kernel's own: negative ones are -errno. Interrupted calls are repeated. Any thread; one
/// descriptor is used by one thread at a time.
class DeviceCalls {
 public:
  virtual ~DeviceCalls() = default;
  /// For reading and writing, not blocking; the descriptor, or -errno.
  virtual int open(const char* path) noexcept = 0;
  virtual void close(int descriptor) noexcept = 0;
  virtual int ioctl(int descriptor, unsigned long request, void* argument) noexcept = 0;
  /// A shared mapping for reading; nullptr if refused.
  virtual std::byte* map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept = 0;
  virtual void unmap(std::byte* memory, std::size_t bytes) noexcept = 0;
  /// Waits for data or trouble. The revents of poll(2), 0 when the time is over, or -errno.
  virtual int poll(int descriptor, std::chrono::nanoseconds longest) noexcept = 0;
  virtual Timestamp now() noexcept = 0;
};

/// The real ones.
class KernelCalls final : public DeviceCalls {
 public:
  int open(const char* path) noexcept override;
  void close(int descriptor) noexcept override;
  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override;
  std::byte* map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept override;
  void unmap(std::byte* memory, std::size_t bytes) noexcept override;
  int poll(int descriptor, std::chrono::nanoseconds longest) noexcept override;
  Timestamp now() noexcept override { return std::chrono::steady_clock::now(); }
};

/// An open device node.
class DeviceNode {
 public:
  DeviceNode() = default;
  /// Look at descriptor(): negative if it could not be opened.
  DeviceNode(DeviceCalls& calls, const char* path) noexcept : calls_(&calls), descriptor_(calls.open(path)) {}
  DeviceNode(DeviceNode&& other) noexcept { *this = static_cast<DeviceNode&&>(other); }
  DeviceNode& operator=(DeviceNode&& other) noexcept;
  DeviceNode(const DeviceNode&) = delete;
  DeviceNode& operator=(const DeviceNode&) = delete;
  ~DeviceNode() { close(); }

  int descriptor() const noexcept { return descriptor_; }
  void close() noexcept;
  /// 0 or more, or -errno.
  int ioctl(unsigned long request, void* argument) noexcept {
    return calls_->ioctl(descriptor_, request, argument);
  }
  DeviceCalls& calls() noexcept { return *calls_; }

 private:
  DeviceCalls* calls_ = nullptr;
  int descriptor_ = -1;
};

}  // namespace glint
