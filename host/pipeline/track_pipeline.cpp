// SPDX-License-Identifier: MIT
// The tracking loop: no lock, log or allocation between blobs and points once it is warm.
#include "host/pipeline/track_pipeline.hpp"

#include <utility>

namespace glint {
namespace {

constexpr std::size_t kResults = 32;  // a third of a second at 90 Hz for a slow disk
constexpr std::size_t kPointsReserved = 512;
constexpr std::size_t kEventsReserved = 40;
constexpr std::size_t kHealthEventsReserved = 64;

}  // namespace

TrackPipeline::TrackPipeline(std::unique_ptr<TickInput> input, const Calibration& calibration,
                             const MatchOptions& match, const TrackOptions& track,
                             std::function<void()> on_track_thread)
    : input_(std::move(input)),
      matcher_(calibration, match),
      tracker_(track),
      health_(calibration, match),
      on_track_thread_(std::move(on_track_thread)),
      results_(kResults),
      spares_(kResults) {
  for (std::size_t i = 0; i < kResults; ++i) {
    auto result = std::make_unique<TickResult>();
    result->points.reserve(kPointsReserved);
    result->events.reserve(kEventsReserved);
    result->health.reserve(kHealthEventsReserved);
    (void)spares_.push(std::move(result));
  }
}

TrackPipeline::~TrackPipeline() {
  input_->stop();
  results_.close();
  spares_.close();
  if (thread_.joinable()) thread_.join();
}

std::unique_ptr<TickResult> TrackPipeline::spare(bool live) noexcept {
  std::unique_ptr<TickResult> result;
  const bool there = live ? spares_.pop(result) : spares_.wait_pop(result);
  return there ? std::move(result) : nullptr;
}

void TrackPipeline::watch(const TickBlobs& tick, std::span<const Point> points,
                          std::span<const TrackedPoint> tracked) noexcept {
  watched_.clear();
  for (const TrackedPoint& point : tracked) watched_.push_back({point.point, point.velocity_in_world});
  health_.watch({tick.exposed, tick.frames, tick.cameras, points, watched_});
  for (const HealthEvent& event : health_.events())
    if (health_events_.size() < kHealthEventsReserved) health_events_.push_back(event);
}

void TrackPipeline::track_loop() noexcept {
  const bool live = input_->live();
  TickBlobs tick;
  std::vector<Prediction> predictions;
  std::vector<Point> points;
  std::vector<TrackedPoint> tracked;
  predictions.reserve(kPointsReserved);
  points.reserve(kPointsReserved);
  tracked.reserve(kPointsReserved);
  watched_.reserve(kPointsReserved);
  health_events_.reserve(kHealthEventsReserved);
  ReadStatus status = ReadStatus::Ok;
  while ((status = input_->next(tick)) == ReadStatus::Ok) {
    tracker_.predict(tick.exposed, predictions);
    if (tick.dark) {
      tracked.clear();
    } else {
      matcher_.match(tick.cameras, predictions, points, match_counters_);
      tracker_.update(points, tracked, track_counters_);
    }
    const Timestamp finished = std::chrono::steady_clock::now();
    if (ticks_.fetch_add(1, std::memory_order_relaxed) == 0 && on_track_thread_) on_track_thread_();
    points_.fetch_add(tracked.size(), std::memory_order_relaxed);

    std::unique_ptr<TickResult> result = spare(live);
    if (!result) {
      if (!live) break;  // the output is gone
      results_dropped_.fetch_add(1, std::memory_order_relaxed);
      if (!tick.dark) watch(tick, points, tracked);
      continue;
    }
    result->trigger = tick.trigger;
    result->exposed = tick.exposed;
    result->delivered = tick.delivered;
    result->detected = tick.detected;
    result->finished = finished;
    result->overflow = tick.overflow;
    result->frames = tick.frames;
    result->live = tick.live;
    result->blobs = 0;
    for (const auto& blobs : tick.cameras) result->blobs += static_cast<std::uint32_t>(blobs.size());
    result->points.assign(tracked.begin(), tracked.end());
    result->unproven = tick.unproven;
    result->dark = tick.dark;
    result->events.assign(tick.events.begin(), tick.events.end());
    result->health.assign(health_events_.begin(), health_events_.end());
    health_events_.clear();
    (void)results_.push(std::move(result));  // there are as many slots as results
    if (!tick.dark) watch(tick, points, tracked);
  }
  end_ = status == ReadStatus::Ok ? ReadStatus::End : status;
  done_.store(true, std::memory_order_release);
  results_.close();
}

ReadStatus TrackPipeline::run(const std::function<void(const TickResult&)>& on_result) {
  thread_ = std::thread([this] { track_loop(); });
  std::unique_ptr<TickResult> result;
  while (results_.wait_pop(result)) {
    on_result(*result);
    (void)spares_.push(std::move(result));
  }
  thread_.join();
  problem_ = input_->problem();
  return end_;
}

TrackCountersSnapshot TrackPipeline::counters() const noexcept {
  TrackCountersSnapshot c;
  c.ticks = ticks_.load(std::memory_order_relaxed);
  c.points = points_.load(std::memory_order_relaxed);
  c.results_dropped = results_dropped_.load(std::memory_order_relaxed);
  if (done_.load(std::memory_order_acquire)) {
    c.match = match_counters_;
    c.track = track_counters_;
  }
  return c;
}

}  // namespace glint
