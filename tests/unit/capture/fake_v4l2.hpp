// SPDX-License-Identifier: MIT
// V4L2 drivers that do what a test tells them.
#pragma once

#include <linux/videodev2.h>

#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "host/capture/v4l2/device_calls.hpp"

namespace glint::test {

struct FakeSize {
  std::uint32_t width_px = 64, height_px = 48;
  std::vector<double> rates_hz{100.0};  ///< whole numbers; empty: the driver does not say
};

struct FakeFormat {
  std::uint32_t fourcc = V4L2_PIX_FMT_GREY;
  std::vector<FakeSize> sizes{FakeSize{}};
  bool stepwise = false;  ///< sizes[0] to sizes[1] in steps of 8
};

struct FakeControl {
  std::uint32_t id = 0, type = V4L2_CTRL_TYPE_INTEGER;
  std::string name;
  std::int64_t lowest = 0, highest = 100, step = 1, usual = 50, value = 50;
  std::vector<std::string> menu;  ///< an empty name: a gap
  std::uint32_t flags = 0;
  /// Refused with this errno while `until` (if set) has not the value 1.
  int refusal = 0;
  std::uint32_t until = 0;
};

/// What one frame brings.
struct FakeFrame {
  std::vector<std::uint8_t> bytes;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  std::optional<timeval> stamp;  ///< else the time of its pulse
  std::optional<std::uint32_t> bytesused;
  int count = 1;  ///< how often it comes
};

/// One camera. Change it while the driver is in use only through FakeV4l2::with().
struct FakeCamera {
  std::string card = "Fake camera", driver = "fake";
  std::uint32_t abilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::vector<FakeFormat> formats{FakeFormat{}};
  std::vector<FakeControl> controls;
  bool takes_pointers = false, sets_rate = true;
  std::uint32_t more_stride_bytes = 0, most_buffers = 32;
  bool plugged = true, hung = false;
  int open_error = 0;
  double rate_hz = 100.0;       ///< of the pulses
  double hidden_rate_hz = 0.0;  ///< one that can be set and is not listed
  /// Fills in the n-th pulse's frame, counted from STREAMON; false: never sent. Default: GREY, all pixels n.
  std::function<bool(std::uint64_t pulse, FakeFrame& frame)> frame;
  /// Answers of coming calls by request: an errno, or 0 for "as usual".
  std::map<unsigned long, std::deque<int>> answers;
  std::uint32_t next_sequence = 0;
  std::uint64_t opened = 0, delivered = 0, lost = 0;

  // The driver's own state.
  struct Buffer {
    std::vector<std::uint8_t> memory;
    std::uint8_t* pointer = nullptr;
    std::size_t bytes = 0;
    bool queued = false;
  };
  std::uint32_t fourcc = 0, width_px = 0, height_px = 0;
  double set_rate_hz = 30.0;
  std::uint32_t memory = 0;
  std::vector<Buffer> buffers;
  std::vector<std::uint32_t> waiting;
  std::vector<v4l2_buffer> done;
  FakeFrame scratch;
  bool streaming = false;
  std::uint64_t pulse = 0;
  Timestamp started{};
};

std::chrono::nanoseconds period_of(const FakeCamera& camera);
Timestamp next_pulse(const FakeCamera& camera);

/// Time is real, or, for one thread alone, moves only when poll() waits.
class FakeV4l2 final : public DeviceCalls {
 public:
  enum class Time : std::uint8_t { Real, Virtual };
  explicit FakeV4l2(Time time = Time::Virtual) : virtual_(time == Time::Virtual) {}

  FakeCamera& add(const std::string& path) { return cameras_[path]; }
  /// Under the driver's lock, from any thread.
  template <typename Change>
  auto with(const std::string& path, const Change& change) {
    const std::lock_guard lock(mutex_);
    return change(cameras_.at(path));
  }

  int open(const char* path) noexcept override;
  void close(int descriptor) noexcept override;
  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override;
  std::byte* map(int descriptor, std::size_t bytes, std::int64_t offset) noexcept override;
  void unmap(std::byte* memory, std::size_t bytes) noexcept override;
  int poll(int descriptor, std::chrono::nanoseconds longest) noexcept override;
  Timestamp now() noexcept override;

  int open_nodes() const { return static_cast<int>(open_.size()); }
  int mappings() const { return mappings_; }

 private:
  int answer(FakeCamera& camera, unsigned long request, void* argument);
  void produce(FakeCamera& camera);
  void fill(FakeCamera& camera, const FakeFrame& frame, Timestamp taken);

  const bool virtual_;
  std::mutex mutex_;
  std::map<std::string, FakeCamera> cameras_;
  std::map<int, FakeCamera*> open_;
  int next_descriptor_ = 100, mappings_ = 0;
  Timestamp now_{std::chrono::seconds(1000)};
};

}  // namespace glint::test
