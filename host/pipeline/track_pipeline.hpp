// SPDX-License-Identifier: MIT
// Blobs to tracks: the tracking thread, and the results on their way to the output thread.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "host/base/ring.hpp"
#include "host/pipeline/tick_input.hpp"
#include "host/pipeline/track_step.hpp"

namespace glint {

/// The outcome of one exposure.
struct TickResult {
  TriggerNo trigger{};
  Timestamp exposed{}, delivered{}, detected{}, finished{};
  std::uint32_t blobs = 0;
  std::uint32_t overflow = 0;        ///< bit set of cameras
  std::uint32_t frames = 0;          ///< bit set of cameras whose frame was used; of blob files: all cameras
  std::optional<LiveTimes> live;     ///< as in FrameSet
  std::vector<TrackedPoint> points;  ///< none in the dark: tracks coast
  std::optional<std::uint32_t> unproven;  ///< as in TickBlobs
  bool dark = false;                      ///< likewise
  std::vector<AlignmentEvent> events;     ///< likewise
  /// Cameras whose condition changed by what was seen up to the exposure before: they are looked at when the
  /// points are out.
  std::vector<HealthEvent> health;
  /// Of this exposure, after those of exposures before whose result was dropped.
  std::vector<IdentityEvent> identity;
  std::vector<TrackedBody> bodies;     ///< none in the dark
  std::vector<BodyEvent> body_events;  ///< as those of identity

  /// None of the point's cameras may show another pulse; none: nothing is coded, nobody knows.
  std::optional<bool> aligned(const TrackedPoint& point) const noexcept {
    if (!unproven) return std::nullopt;
    return (point.cameras & *unproven) == 0;
  }
  double detection_s() const noexcept { return seconds_between(delivered, detected); }
  double end_to_end_s() const noexcept { return seconds_between(delivered, finished); }
};

struct TrackCountersSnapshot {
  std::uint64_t ticks = 0, points = 0;
  std::uint64_t results_dropped = 0;  ///< live only: the output was too slow
  MatchCounters match;                ///< complete after the end
  TrackCounters track;                ///< complete after the end
  BodyCounters body;                  ///< complete after the end
};

/// Owns the tracking thread. The caller's thread is the output thread: it calls run().
class TrackPipeline {
 public:
  /// on_track_thread is called by that thread after its first tick, so that whatever a Vulkan driver starts
  /// in the first submission does not inherit what it sets. It must not throw. `bodies`: as of TrackStep.
  TrackPipeline(std::unique_ptr<TickInput> input, const Calibration& calibration, const MatchOptions& match,
                const TrackOptions& track, std::span<const BodyModel> bodies = {},
                std::function<void()> on_track_thread = {});
  ~TrackPipeline();

  /// Tracks to the end of the input; `on_result` is called for every tick, in order, on this thread, and may
  /// block: a recording waits for it, of a live source results are dropped, counted. Returns Failed with
  /// problem() set when the input failed.
  ReadStatus run(const std::function<void(const TickResult&)>& on_result);

  /// Any thread, also a signal-watching one.
  void stop() noexcept { input_->stop(); }
  TickInput& input() noexcept { return *input_; }
  TrackCountersSnapshot counters() const noexcept;
  /// After the end.
  HealthReport health() const { return step_.health().report(); }
  const std::string& problem() const noexcept { return problem_; }

 private:
  void track_loop() noexcept;
  void watch(const TickBlobs& tick) noexcept;
  std::unique_ptr<TickResult> spare(bool live) noexcept;

  std::unique_ptr<TickInput> input_;
  TrackStep step_;                              // the tracking thread's
  std::vector<HealthEvent> health_events_;      // likewise: not yet handed on
  std::vector<IdentityEvent> identity_events_;  // not yet in a result
  std::vector<BodyEvent> body_events_;          // likewise
  std::function<void()> on_track_thread_;
  Ring<std::unique_ptr<TickResult>> results_, spares_;
  std::atomic<std::uint64_t> ticks_{0}, points_{0}, results_dropped_{0};
  std::atomic<bool> done_{false};
  ReadStatus end_ = ReadStatus::End;
  std::string problem_;
  std::thread thread_;
};

}  // namespace glint
