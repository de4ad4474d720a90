// SPDX-License-Identifier: MIT
// Errors out of place, and replies with wrong fields.
#include "tests/unit/capture/spoilt_calls.hpp"

#include <array>
#include <cerrno>
#include <cstddef>

namespace glint::test {

bool SpoiltCalls::spoil() {
  calls_.fetch_add(1, std::memory_order_relaxed);
  return choices_.below(256) < spoilt_of_256_;
}

int SpoiltCalls::some_error() {
  return -choices_.one_of(
      std::array{EIO, EINVAL, ENODEV, EAGAIN, EBUSY, ENOTTY, ENOMEM, EPIPE, ENOSPC, EACCES});
}

int SpoiltCalls::open(const char* path) noexcept { return spoil() ? some_error() : driver_.open(path); }

std::byte* SpoiltCalls::map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept {
  return spoil() ? nullptr : driver_.map(descriptor, bytes, offset);
}

int SpoiltCalls::poll(int descriptor, std::chrono::nanoseconds longest) noexcept {
  const int events = driver_.poll(descriptor, longest);
  return spoil() ? static_cast<int>(choices_.below(0x40)) - 4 : events;
}

int SpoiltCalls::ioctl(int descriptor, unsigned long request, void* argument) noexcept {
  if (!spoil()) return driver_.ioctl(descriptor, request, argument);
  if (choices_.one_in(3)) return some_error();
  const int result = driver_.ioctl(descriptor, request, argument);
  // A driver may say anything about a picture, but where memory is and how long is the kernel's word.
  switch (request) {
    case VIDIOC_QUERYBUF:
    case VIDIOC_QBUF:
      return result;
    case VIDIOC_REQBUFS:
      static_cast<v4l2_requestbuffers*>(argument)->count = choices_.anything() % 64;
      break;
    case VIDIOC_G_EXT_CTRLS:
    case VIDIOC_S_EXT_CTRLS:
      static_cast<v4l2_ext_controls*>(argument)->controls[0].value =
          static_cast<std::int32_t>(choices_.anything());
      break;
    case VIDIOC_DQBUF:
      spoil_buffer(*static_cast<v4l2_buffer*>(argument));
      break;
    default:
      spoil_bytes(argument, _IOC_SIZE(request));
  }
  return choices_.one_in(8) ? 0 : result;
}

void SpoiltCalls::spoil_bytes(void* argument, std::size_t size) {
  auto* const bytes = static_cast<unsigned char*>(argument);
  for (std::uint32_t left = 1 + choices_.below(6); left > 0; --left) {
    const auto byte = static_cast<unsigned char>(choices_.anything());
    bytes[choices_.anything() % size] = choices_.one_of(std::array<unsigned char, 4>{0, 0xff, 0x7f, byte});
  }
}

void SpoiltCalls::spoil_buffer(v4l2_buffer& buffer) {
  const std::uint32_t anything = choices_.anything();
  switch (choices_.below(6)) {
    case 0:
      wrong_buffer_ = true;
      buffer.index = anything % 2 == 0 ? anything : anything % 8;
      break;
    case 1:
      buffer.bytesused = anything % 2 == 0 ? anything : anything % 8000;
      break;
    case 2:
      buffer.flags = anything;
      break;
    case 3:
      buffer.sequence = anything;
      break;
    case 4:
      buffer.timestamp.tv_sec = static_cast<long>(std::uint64_t{anything} << 32 | choices_.anything());
      break;
    default:
      buffer.timestamp.tv_usec = static_cast<long>(std::uint64_t{anything} << 32 | choices_.anything());
  }
}

}  // namespace glint::test
