// SPDX-License-Identifier: MIT
// A driver whose answers are not to be trusted.
#pragma once

#include <linux/videodev2.h>

#include <atomic>
#include <cstdint>

#include "tests/unit/capture/choices.hpp"
#include "tests/unit/capture/fake_v4l2.hpp"

namespace glint::test {

/// Passes calls on to a driver that behaves, and spoils some of the answers. One thread, but for calls().
class SpoiltCalls final : public DeviceCalls {
 public:
  /// Spoils so many answers of 256.
  SpoiltCalls(FakeV4l2& driver, Choices& choices, std::uint32_t spoilt_of_256)
      : driver_(driver), choices_(choices), spoilt_of_256_(spoilt_of_256) {}

  int open(const char* path) noexcept override;
  void close(int descriptor) noexcept override { driver_.close(descriptor); }
  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override;
  std::byte* map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept override;
  void unmap(std::byte* memory, std::size_t bytes) noexcept override { driver_.unmap(memory, bytes); }
  int poll(int descriptor, std::chrono::nanoseconds longest) noexcept override;
  Timestamp now() noexcept override { return driver_.now(); }

  /// Calls that reached the driver or would have. Any thread.
  std::uint64_t calls() const noexcept { return calls_.load(std::memory_order_relaxed); }
  /// A buffer was given back under another's number: the driver may go on writing where it should not.
  bool wrong_buffer() const noexcept { return wrong_buffer_; }

 private:
  bool spoil();
  int some_error();
  void spoil_buffer(v4l2_buffer& buffer);
  void spoil_bytes(void* argument, std::size_t size);

  FakeV4l2& driver_;
  Choices& choices_;
  const std::uint32_t spoilt_of_256_;
  std::atomic<std::uint64_t> calls_{0};
  bool wrong_buffer_ = false;
};

}  // namespace glint::test
