// SPDX-License-Identifier: MIT
// One exposure after the other: blobs to points, to tracks, to rigid bodies, and the watch over the cameras.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "host/health/camera_health.hpp"
#include "host/match/matcher.hpp"
#include "host/pipeline/body_step.hpp"
#include "host/pipeline/tick_input.hpp"
#include "host/track/tracker.hpp"

namespace glint {

/// Thread-bound. No allocation once warm.
class TrackStep {
 public:
  /// `bodies`: rigid bodies to look for, copied. Throws Error for what cannot be tracked.
  TrackStep(const Calibration& calibration, const MatchOptions& match, const TrackOptions& track,
            std::span<const BodyModel> bodies = {});

  /// In the order of time. In the dark there are no points, and tracks coast.
  void take(const TickBlobs& tick) noexcept;
  /// Of the last take().
  std::span<const Point> points() const noexcept { return points_; }
  std::span<const TrackedPoint> tracked() const noexcept { return tracked_; }
  std::span<const IdentityEvent> identity_events() const noexcept {
    return dark_ ? std::span<const IdentityEvent>() : tracker_.events();
  }
  std::span<const TrackedBody> bodies() const noexcept {
    return dark_ || !bodies_ ? std::span<const TrackedBody>() : bodies_->bodies();
  }
  std::span<const BodyEvent> body_events() const noexcept {
    return dark_ || !bodies_ ? std::span<const BodyEvent>() : bodies_->events();
  }

  /// Looks at the cameras by the last take(), which had this tick; apart from it, since points need not wait
  /// for that. Nothing in the dark.
  void watch(const TickBlobs& tick) noexcept;
  const CameraHealth& health() const noexcept { return health_; }

  const MatchCounters& match_counters() const noexcept { return match_counters_; }
  const TrackCounters& track_counters() const noexcept { return track_counters_; }
  BodyCounters body_counters() const noexcept { return bodies_ ? bodies_->counters() : BodyCounters(); }

 private:
  Matcher matcher_;
  Tracker tracker_;
  std::optional<BodyStep> bodies_;  // none: no bodies are looked for
  CameraHealth health_;
  std::vector<Prediction> predictions_;
  std::vector<Point> points_;
  std::vector<TrackedPoint> tracked_;
  std::vector<WatchedMarker> watched_;
  bool dark_ = false;
  MatchCounters match_counters_;
  TrackCounters track_counters_;
};

}  // namespace glint
