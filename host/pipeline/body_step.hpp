// SPDX-License-Identifier: MIT
// Rigid bodies in the pipeline: what they expect sharpens what tracks expect, and tracks make their poses.
#pragma once

#include <span>
#include <vector>

#include "host/base/ids.hpp"
#include "host/body/body_tracker.hpp"
#include "host/geometry/camera.hpp"
#include "host/match/matcher.hpp"
#include "host/track/tracker.hpp"

namespace glint {

/// Thread-bound. No allocation once warm.
class BodyStep {
 public:
  /// Throws Error for models that cannot be tracked, and for a rig that knows only a plane.
  BodyStep(const Calibration& calibration, const MatchOptions& match, std::span<const BodyModel> bodies);

  /// Moves bodies to time `exposed`. Where a body knows better than the track of one of its markers where the
  /// marker is, it replaces that track's prediction, unless it is itself in doubt or was not measured lately.
  /// `predictions` are in the order of track numbers.
  void predict(Timestamp exposed, std::span<Prediction> predictions);
  /// `points` and the tracks made of them at the exposure that predict() was called for. Not to be called
  /// where the light was off: bodies then coast.
  void update(std::span<const Point> points, std::span<const TrackedPoint> tracked);

  /// Of the last update().
  std::span<const TrackedBody> bodies() const noexcept { return bodies_; }
  std::span<const BodyEvent> events() const noexcept { return tracker_.events(); }
  const BodyCounters& counters() const noexcept { return counters_; }

 private:
  bool advises(std::uint32_t body) const noexcept;
  double calibration_variance_m2(const Eigen::Vector3d& position_in_world) const noexcept;
  void add_views(const Point& point);

  std::vector<Camera> cameras_;
  std::vector<double> calibration_px2_;  // by camera, variance per axis
  double marker_radius_m_;
  BodyTracker tracker_;
  std::vector<ExpectedMarker> expected_;
  std::vector<Observation> views_;
  std::vector<MarkerSample> samples_;
  std::vector<TrackedBody> bodies_;
  BodyCounters counters_;
};

}  // namespace glint
