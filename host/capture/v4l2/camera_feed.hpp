// SPDX-License-Identifier: MIT
// The thread of one camera: captures, decodes, and brings the camera back when it has gone.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "host/base/ring.hpp"
#include "host/capture/v4l2/camera_stream.hpp"
#include "host/capture/v4l2/wake_up.hpp"

namespace glint {

/// What a camera's thread tells the reader of frame sets, in the order in which it happened.
struct FeedItem {
  enum class Kind : std::uint8_t {
    Frame,
    Gone,  ///< unplugged, failed or silent: do not wait for it
    Back,  ///< a frame follows
  };
  Kind kind = Kind::Frame;
  Frame frame;
  Timestamp arrived{};
};

/// Called from cameras' threads, and only when something has happened to a camera; may block.
using CameraEventHandler = std::function<void(const std::string&)>;

struct FeedOptions {
  CameraEventHandler on_event;
  std::function<void()> on_thread;  ///< called first by each camera's thread; must not throw
  DeviceRoots roots;
  std::chrono::milliseconds retry{500};  ///< between attempts to open a camera that has gone
};

struct FeedCounts {
  std::uint64_t frames = 0;  ///< that the driver gave, flawed ones included
  std::array<std::uint64_t, kFrameFlaws> flaws{};
  std::uint64_t not_taken = 0;                          ///< dropped by us because the reader was behind
  std::uint64_t unplugged = 0, failed = 0, silent = 0;  ///< times
};

class CameraFeed {
 public:
  /// Frames between this thread and the reader.
  static constexpr std::size_t kRing = 6;

  /// Opens the camera. Throws Error. `calls`, `reader` and what on_event uses must outlive the feed.
  CameraFeed(DeviceCalls& calls, CameraRequest request, WakeUp& reader, const FeedOptions& options);
  ~CameraFeed() { stop(); }
  CameraFeed(const CameraFeed&) = delete;
  CameraFeed& operator=(const CameraFeed&) = delete;

  /// See FrameSource::set_limit(). Not between start() and stop().
  void set_limit(std::span<const std::uint8_t> limit);
  /// Starts streaming and the thread. Throws Error.
  void start(FramePool& pool, CameraId camera);
  /// Ends the thread and gives back all frames. The camera stays open.
  void stop() noexcept;
  /// The reader: false if there is nothing.
  [[nodiscard]] bool take(FeedItem& item) noexcept { return ring_.pop(item); }

  const std::string& name() const noexcept { return request_.name; }
  FrameSize size() const noexcept { return request_.format.size; }
  double rate_hz() const noexcept { return request_.format.rate_hz; }  ///< 0: the driver has no say in it
  /// Any thread.
  FeedCounts counts() const noexcept;

 private:
  void run(const std::stop_token& stop) noexcept;
  void stream(const std::stop_token& stop);
  void reopen();
  void pass_on(const std::stop_token& stop, FeedItem::Kind kind) noexcept;
  void pass_on(ReceivedFrame& received) noexcept;
  void note_absence(const std::stop_token& stop, const std::string& text);
  void note_return(const std::stop_token& stop);
  void say(const std::string& text) const;

  DeviceCalls& calls_;
  CameraRequest request_;
  WakeUp& reader_;
  FeedOptions options_;
  std::unique_ptr<CameraStream> stream_;  // none while the camera is gone
  FramePool* pool_ = nullptr;
  CameraId camera_{};
  std::vector<std::uint8_t> limit_;  // for a camera that comes back
  Ring<FeedItem> ring_;
  Timestamp last_frame_{};  // or the start
  bool absent_ = false;
  Timestamp silence_said_{};  // when the last silence was told of
  std::string absence_;       // what was told of the absence; "" if nothing
  std::string last_refusal_;
  unsigned refusals_ = 0;  // of the same kind in a row
  std::atomic<std::uint64_t> frames_{0}, not_taken_{0}, unplugged_{0}, failed_{0}, silent_{0};
  std::array<std::atomic<std::uint64_t>, kFrameFlaws> flaws_{};
  std::mutex sleep_mutex_;
  std::condition_variable_any sleep_;
  std::jthread thread_;  // last: it uses everything above
};

}  // namespace glint
