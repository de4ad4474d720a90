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
constexpr std::size_t kIdentityEventsReserved = 128;
constexpr std::size_t kBodyEventsReserved = 128;

}  // namespace

TrackPipeline::TrackPipeline(std::unique_ptr<TickInput> input, const Calibration& calibration,
                             const MatchOptions& match, const TrackOptions& track,
                             std::span<const BodyModel> bodies, std::function<void()> on_track_thread)
    : input_(std::move(input)),
      step_(calibration, match, track, bodies),
      on_track_thread_(std::move(on_track_thread)),
      results_(kResults),
      spares_(kResults) {
  for (std::size_t i = 0; i < kResults; ++i) {
    auto result = std::make_unique<TickResult>();
    result->points.reserve(kPointsReserved);
    result->events.reserve(kEventsReserved);
    result->health.reserve(kHealthEventsReserved);
    result->identity.reserve(kIdentityEventsReserved);
    result->bodies.reserve(bodies.size());
    result->body_events.reserve(kBodyEventsReserved);
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

void TrackPipeline::watch(const TickBlobs& tick) noexcept {
  if (tick.dark) return;
  step_.watch(tick);
  for (const HealthEvent& event : step_.health().events())
    if (health_events_.size() < kHealthEventsReserved) health_events_.push_back(event);
}

void TrackPipeline::track_loop() noexcept {
  const bool live = input_->live();
  TickBlobs tick;
  health_events_.reserve(kHealthEventsReserved);
  identity_events_.reserve(kIdentityEventsReserved);
  body_events_.reserve(kBodyEventsReserved);
  ReadStatus status = ReadStatus::Ok;
  while ((status = input_->next(tick)) == ReadStatus::Ok) {
    step_.take(tick);
    for (const IdentityEvent& event : step_.identity_events())
      if (identity_events_.size() < kIdentityEventsReserved) identity_events_.push_back(event);
    for (const BodyEvent& event : step_.body_events())
      if (body_events_.size() < kBodyEventsReserved) body_events_.push_back(event);
    const Timestamp finished = std::chrono::steady_clock::now();
    if (ticks_.fetch_add(1, std::memory_order_relaxed) == 0 && on_track_thread_) on_track_thread_();
    points_.fetch_add(step_.tracked().size(), std::memory_order_relaxed);

    std::unique_ptr<TickResult> result = spare(live);
    if (!result) {
      if (!live) break;  // the output is gone
      results_dropped_.fetch_add(1, std::memory_order_relaxed);
      watch(tick);
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
    result->points.assign(step_.tracked().begin(), step_.tracked().end());
    result->unproven = tick.unproven;
    result->dark = tick.dark;
    result->events.assign(tick.events.begin(), tick.events.end());
    result->health.assign(health_events_.begin(), health_events_.end());
    health_events_.clear();
    result->identity.assign(identity_events_.begin(), identity_events_.end());
    identity_events_.clear();
    result->bodies.assign(step_.bodies().begin(), step_.bodies().end());
    result->body_events.assign(body_events_.begin(), body_events_.end());
    body_events_.clear();
    (void)results_.push(std::move(result));  // there are as many slots as results
    watch(tick);
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
    c.match = step_.match_counters();
    c.track = step_.track_counters();
    c.body = step_.body_counters();
  }
  return c;
}

}  // namespace glint
