// SPDX-License-Identifier: MIT
// Streaming, and what happens around its faults.
#include "host/capture/v4l2/camera_feed.hpp"

#include <cstdio>
#include <utility>

namespace glint {
namespace {

constexpr std::chrono::milliseconds kSlice{50};  // a stop is noticed within this
// A camera that is triggered too slowly falls silent at every frame; nobody wants to read that.
constexpr std::chrono::seconds kBetweenSilences{2};
// A camera that has just been plugged in is refused for a moment, until its node's permissions are set.
constexpr unsigned kRefusalsUntilSaid = 4;
constexpr const char* kUnplugged = "was unplugged; the others go on, and it is taken back when it returns";

std::string text_of_seconds(double seconds) {
  char text[32];
  std::snprintf(text, sizeof text, seconds < 1.0 ? "%.0f ms" : "%.1f s",
                seconds < 1.0 ? seconds * 1e3 : seconds);
  return text;
}

}  // namespace

CameraFeed::CameraFeed(DeviceCalls& calls, CameraRequest request, WakeUp& reader, const FeedOptions& options)
    : calls_(calls),
      request_(std::move(request)),
      reader_(reader),
      options_(options),
      stream_(std::make_unique<CameraStream>(calls_, options_.roots, request_)),
      ring_(kRing) {
  // From now on this very camera with these very pictures, whatever number its node gets next time.
  const DeviceIdentity& identity = stream_->identity();
  if (request_.device.starts_with('/') && !identity.by_path.empty()) request_.device = identity.by_path;
  request_.format.size = stream_->format().size;
  request_.format.rate_hz = stream_->format().rate_hz;
}

void CameraFeed::set_limit(std::span<const std::uint8_t> limit) {
  limit_.assign(limit.begin(), limit.end());
  if (stream_) stream_->set_limit(limit_);
}

void CameraFeed::start(FramePool& pool, CameraId camera) {
  pool_ = &pool;
  camera_ = camera;
  last_frame_ = calls_.now();
  absent_ = false;
  absence_.clear();
  try {
    if (stream_) stream_->start(pool, camera);
  } catch (const NoSuchCamera&) {  // unplugged while nobody read
    unplugged_.fetch_add(1, std::memory_order_relaxed);
    stream_.reset();
    note_absence({}, kUnplugged);
  }
  if (!stream_) note_absence({}, "");  // or before that
  thread_ = std::jthread([this](const std::stop_token& token) { run(token); });
}

void CameraFeed::stop() noexcept {
  thread_.request_stop();
  if (thread_.joinable()) thread_.join();
  if (stream_) stream_->stop();
  for (FeedItem item; ring_.pop(item);) item.frame = {};
}

FeedCounts CameraFeed::counts() const noexcept {
  const auto value = [](const std::atomic<std::uint64_t>& count) {
    return count.load(std::memory_order_relaxed);
  };
  FeedCounts counts;
  counts.frames = value(frames_);
  for (std::size_t n = 0; n < kFrameFlaws; ++n) counts.flaws[n] = value(flaws_[n]);
  counts.not_taken = value(not_taken_);
  counts.unplugged = value(unplugged_);
  counts.failed = value(failed_);
  counts.silent = value(silent_);
  return counts;
}

void CameraFeed::run(const std::stop_token& stop) noexcept {
  if (options_.on_thread) options_.on_thread();
  bool retry_at_once = false;
  while (!stop.stop_requested()) {
    try {
      if (stream_) {
        const std::uint64_t before = frames_.load(std::memory_order_relaxed);
        stream(stop);
        retry_at_once = frames_.load(std::memory_order_relaxed) > before;
        continue;
      }
      if (!std::exchange(retry_at_once, false)) {
        std::unique_lock lock(sleep_mutex_);
        sleep_.wait_for(lock, stop, options_.retry, [] { return false; });
        if (stop.stop_requested()) return;
      }
      reopen();
    } catch (const std::exception&) {
      stream_.reset();  // out of memory: try again in a while
    }
  }
}

/// Until the camera is gone or a stop is asked for.
void CameraFeed::stream(const std::stop_token& stop) {
  ReceivedFrame received;
  while (!stop.stop_requested()) {
    switch (stream_->next(received, kSlice)) {
      case StreamStatus::Frame:
        if (absent_) note_return(stop);
        last_frame_ = received.arrived;
        pass_on(received);
        break;
      case StreamStatus::Nothing:
        if (stream_->silent() && !absent_) {
          silent_.fetch_add(1, std::memory_order_relaxed);
          const Timestamp now = calls_.now();
          const bool say_it = now >= silence_said_ + kBetweenSilences || silence_said_ == Timestamp{};
          if (say_it) silence_said_ = now;
          note_absence(stop, say_it ? "gives no frames" : "");
        }
        break;
      case StreamStatus::Unplugged:
        unplugged_.fetch_add(1, std::memory_order_relaxed);
        stream_.reset();
        note_absence(stop, kUnplugged);
        return;
      case StreamStatus::Broken: {
        failed_.fetch_add(1, std::memory_order_relaxed);
        const std::string why = stream_->problem();
        stream_.reset();
        note_absence(stop, "failed: " + why + "; it is being opened again");
        return;
      }
    }
  }
}

/// One attempt.
void CameraFeed::reopen() {
  try {
    auto stream = std::make_unique<CameraStream>(calls_, options_.roots, request_);
    if (!limit_.empty()) stream->set_limit(limit_);
    stream->start(*pool_, camera_);
    stream_ = std::move(stream);
    refusals_ = 0;
    last_refusal_.clear();
  } catch (const NoSuchCamera&) {
    refusals_ = 0;
  } catch (const Error& error) {
    refusals_ = error.what() == last_refusal_ ? refusals_ + 1 : 1;
    last_refusal_ = error.what();
    if (refusals_ == kRefusalsUntilSaid && options_.on_event) options_.on_event(last_refusal_);
  }
}

void CameraFeed::note_absence(const std::stop_token& stop, const std::string& text) {
  if (!std::exchange(absent_, true)) pass_on(stop, FeedItem::Kind::Gone);
  if (text.empty() || text == absence_) return;
  absence_ = text;
  say(text);
}

void CameraFeed::note_return(const std::stop_token& stop) {
  absent_ = false;
  pass_on(stop, FeedItem::Kind::Back);
  if (std::exchange(absence_, {}).empty()) return;
  say("is back (" + stream_->identity().node + "), without frames for " +
      text_of_seconds(seconds_between(last_frame_, calls_.now())));
}

void CameraFeed::say(const std::string& text) const {
  if (options_.on_event) options_.on_event("camera " + request_.name + " " + text);
}

/// News of a camera must arrive; while there are some, it has no frames to lose.
void CameraFeed::pass_on(const std::stop_token& stop, FeedItem::Kind kind) noexcept {
  FeedItem item;
  item.kind = kind;
  item.arrived = calls_.now();
  while (!ring_.push(std::move(item)) && !stop.stop_requested())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  reader_.wake();
}

void CameraFeed::pass_on(ReceivedFrame& received) noexcept {
  frames_.fetch_add(1, std::memory_order_relaxed);
  flaws_[static_cast<std::size_t>(received.flaw)].fetch_add(1, std::memory_order_relaxed);
  // What we drop shows as a gap in the driver's sequence numbers, which the ledger books as lost by the host.
  if (received.flaw == FrameFlaw::NoSlot || received.flaw == FrameFlaw::TooOld) return;
  FeedItem item;
  item.frame = std::move(received.frame);
  item.arrived = received.arrived;
  if (!ring_.push(std::move(item))) not_taken_.fetch_add(1, std::memory_order_relaxed);
  reader_.wake();
}

}  // namespace glint
