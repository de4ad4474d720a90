// SPDX-License-Identifier: MIT
// Time, buffers and frames of the fake driver.
#include "tests/unit/capture/fake_v4l2.hpp"

#include <poll.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <thread>

namespace glint::test {

using std::chrono::nanoseconds;

nanoseconds period_of(const FakeCamera& camera) {
  return nanoseconds(static_cast<std::int64_t>(1e9 / camera.rate_hz));
}

Timestamp next_pulse(const FakeCamera& camera) {
  return camera.started + static_cast<std::int64_t>(camera.pulse + 1) * period_of(camera);
}

int FakeV4l2::open(const char* path) noexcept {
  const std::lock_guard lock(mutex_);
  const auto found = cameras_.find(path);
  if (found == cameras_.end() || !found->second.plugged) return -ENOENT;
  if (found->second.open_error != 0) return -found->second.open_error;
  ++found->second.opened;
  open_[next_descriptor_] = &found->second;
  return next_descriptor_++;
}

void FakeV4l2::close(int descriptor) noexcept {
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(descriptor);
  if (found == open_.end()) return;
  FakeCamera& camera = *found->second;
  camera.streaming = false;
  camera.buffers.clear();
  camera.waiting.clear();
  camera.done.clear();
  open_.erase(found);
}

Timestamp FakeV4l2::now() noexcept { return virtual_ ? now_ : std::chrono::steady_clock::now(); }

std::byte* FakeV4l2::map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept {
  const std::lock_guard lock(mutex_);
  FakeCamera& camera = *open_.at(descriptor);
  const auto index = static_cast<std::size_t>(offset);
  if (index >= camera.buffers.size() || bytes > camera.buffers[index].memory.size()) return nullptr;
  ++mappings_;
  return reinterpret_cast<std::byte*>(camera.buffers[index].memory.data());
}

void FakeV4l2::unmap(std::byte*, std::size_t) noexcept {
  const std::lock_guard lock(mutex_);
  --mappings_;
}

int FakeV4l2::ioctl(int descriptor, unsigned long request, void* argument) noexcept {
  const std::lock_guard lock(mutex_);
  const auto found = open_.find(descriptor);
  if (found == open_.end()) return -EBADF;
  FakeCamera& camera = *found->second;
  if (!camera.plugged) return -ENODEV;
  std::deque<int>& planned = camera.answers[request];
  if (!planned.empty()) {
    const int error = planned.front();
    planned.pop_front();
    if (error != 0) return -error;
  }
  produce(camera);
  return answer(camera, request, argument);
}

/// Frames whose pulses have come; one without a free buffer is lost, and its number with it.
void FakeV4l2::produce(FakeCamera& camera) {
  while (camera.streaming && camera.plugged && !camera.hung) {
    const Timestamp taken = next_pulse(camera);
    if (taken > now()) return;
    const std::uint64_t pulse = camera.pulse++;
    FakeFrame& frame = camera.scratch;
    FakeFrame fresh;
    fresh.bytes.swap(frame.bytes);  // keeps its memory: tests count allocations
    fresh.bytes.clear();
    frame = std::move(fresh);
    if (!camera.frame) {
      frame.bytes.assign(std::size_t{camera.width_px} * camera.height_px, static_cast<std::uint8_t>(pulse));
    } else if (!camera.frame(pulse, frame)) {
      continue;
    }
    for (int n = 0; n < frame.count; ++n) fill(camera, frame, taken);
  }
}

void FakeV4l2::fill(FakeCamera& camera, const FakeFrame& frame, Timestamp taken) {
  const std::uint32_t sequence = camera.next_sequence++;
  if (camera.waiting.empty()) {
    ++camera.lost;
    return;
  }
  const std::uint32_t index = camera.waiting.front();
  camera.waiting.erase(camera.waiting.begin());
  FakeCamera::Buffer& buffer = camera.buffers[index];
  const std::size_t bytes = std::min(frame.bytes.size(), buffer.bytes);
  if (bytes > 0) std::memcpy(buffer.pointer, frame.bytes.data(), bytes);
  v4l2_buffer filled{};
  filled.index = index;
  filled.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  filled.memory = camera.memory;
  filled.bytesused = frame.bytesused.value_or(static_cast<std::uint32_t>(bytes));
  filled.flags = frame.flags;
  filled.sequence = sequence;
  const auto since = std::chrono::duration_cast<std::chrono::microseconds>(taken.time_since_epoch()).count();
  filled.timestamp = frame.stamp.value_or(timeval{since / 1'000'000, since % 1'000'000});
  camera.done.push_back(filled);
  ++camera.delivered;
}

int FakeV4l2::poll(int descriptor, nanoseconds longest) noexcept {
  const Timestamp until = now() + longest;
  for (;;) {
    Timestamp wake = until;
    {
      const std::lock_guard lock(mutex_);
      const auto found = open_.find(descriptor);
      if (found == open_.end()) return POLLNVAL;
      FakeCamera& camera = *found->second;
      if (!camera.plugged) return POLLPRI | POLLERR | POLLHUP;
      std::deque<int>& planned = camera.answers[0];  // of poll itself: revents
      if (!planned.empty()) {
        const int events = planned.front();
        planned.pop_front();
        if (events != 0) return events;
      }
      produce(camera);
      if (!camera.done.empty()) return POLLIN | POLLRDNORM;
      if (now() >= until) return 0;
      if (camera.streaming && !camera.hung) wake = std::min(wake, next_pulse(camera));
    }
    if (virtual_) {
      now_ = wake;
    } else {
      std::this_thread::sleep_until(std::min(wake, now() + std::chrono::milliseconds(1)));
    }
  }
}

}  // namespace glint::test
