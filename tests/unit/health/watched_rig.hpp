// SPDX-License-Identifier: MIT
// The simulated rig without pictures: blobs straight from the truth, matched, tracked and watched.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "host/health/camera_health.hpp"
#include "host/match/matcher.hpp"
#include "host/sim/random.hpp"
#include "host/sim/scene.hpp"
#include "host/track/tracker.hpp"

namespace glint::testing {

struct WatchedRigOptions {
  SimOptions sim;
  MatchOptions match;
  /// What the matcher and the watch are told; the scene's own if none.
  std::optional<Calibration> calibration;
  double centroid_px = 0.04;  ///< noise per axis: that of rendered markers is 0.02 to 0.05
  std::uint32_t clutter = 0;  ///< static blobs of no marker, per camera
};

struct NamedEvent {
  double time_s = 0.0;
  HealthEvent event;
};

/// Blobs have the truth's places, with noise; those that touch are one, those over a learnt spot are none,
/// and frames that are dropped have none.
class WatchedRig {
 public:
  explicit WatchedRig(const WatchedRigOptions& options);

  void run(double seconds);
  const std::vector<NamedEvent>& events() const noexcept { return events_; }
  const CameraHealth& health() const noexcept { return health_; }
  const Scene& scene() const noexcept { return scene_; }
  double watch_s() const noexcept { return watch_s_; }  ///< processor time of CameraHealth::watch()
  double longest_watch_s() const noexcept { return longest_watch_s_; }
  std::uint64_t ticks() const noexcept { return tick_; }

 private:
  void make_blobs();

  WatchedRigOptions options_;
  Scene scene_;
  std::vector<Camera> cameras_;
  Matcher matcher_;
  Tracker tracker_;
  CameraHealth health_;
  sim::NormalTable normal_;
  sim::Random random_;
  TickTruth truth_;
  std::vector<std::vector<Eigen::Vector2d>> clutter_;
  std::vector<std::vector<shaders::BlobRecord>> blobs_;
  std::uint64_t tick_ = 0;
  std::vector<NamedEvent> events_;
  double watch_s_ = 0.0, longest_watch_s_ = 0.0;
};

/// "cam2 bumped 0.20 deg right; cam3 late 8.0 ms", for messages.
std::string text_of(const std::vector<NamedEvent>& events);

}  // namespace glint::testing
