// SPDX-License-Identifier: MIT
// Watches, while markers are tracked, whether each camera still agrees with the others, and says what is
// wrong with one that does not.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/geometry/camera.hpp"
#include "host/match/matcher.hpp"

namespace glint {

enum class CameraCondition : std::uint8_t {
  Unknown,   ///< too little was seen to tell
  Fine,      ///< its blobs are where the other cameras' points should appear
  Drifting,  ///< they are near, but at more than twice the distance that the calibration (its rms_px)
             ///< promises
  Bumped,    ///< a turn of the camera explains where they are
  Late,      ///< it exposes at another time than the others
  Swapped,   ///< its images are another camera's
};

struct CameraState {
  CameraCondition condition = CameraCondition::Unknown;
  /// Bumped: rotation vector of the camera from where it was calibrated to where it is, along its own axes:
  /// x > 0 it looks further up, y > 0 further to the right, z > 0 it was turned clockwise as seen from
  /// behind.
  Eigen::Vector3d turn_rad = Eigen::Vector3d::Zero();
  double offset_px = 0.0;  ///< Bumped: how far that moves its image, root mean square over what was seen
  double late_s = 0.0;     ///< Late: how much later than the others it exposes; negative: earlier
  CameraId swapped_with{};
};

/// A camera's condition changed. A change to Unknown is none: nothing was found out.
struct HealthEvent {
  CameraId camera{};
  CameraState state;
  CameraCondition before = CameraCondition::Unknown;
};

/// What is known of a camera, from all that was seen so far.
struct CameraReport {
  CameraState state;         ///< the last one
  double residual_px = 0.0;  ///< median distance between its blobs and where the others' points should appear
  double expected_px = 0.0;  ///< what the calibration and the centroids' noise promise for that median
  std::uint64_t compared = 0;  ///< points of the others with a blob of this camera within reach
  std::uint64_t agreed = 0;    ///< of these, how many fitted
  std::uint64_t faults = 0;    ///< how often it was found anything else than fine
  /// For a check before work: fine, and never anything else.
  bool green() const noexcept { return state.condition == CameraCondition::Fine && faults == 0; }
};

struct HealthReport {
  std::vector<CameraReport> cameras;  ///< in rig order
};

/// A marker that is being tracked.
struct WatchedMarker {
  std::uint32_t point = 0;  ///< index into HealthInput::points
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();
};

/// One exposure after matching. Everything is borrowed for the call.
struct HealthInput {
  Timestamp exposed{};
  std::uint32_t frames = 0;  ///< bit set of cameras whose frame is there
  std::span<const std::span<const shaders::BlobRecord>> blobs;
  std::span<const Point> points;
  std::span<const WatchedMarker> markers;
};

/// How it judges is told in docs/decisions/0018-health-from-what-the-others-see.md. Needs three cameras;
/// with fewer everything stays Unknown. Thread-bound; allocates only when it is made.
class CameraHealth {
 public:
  /// Cameras in rig order, at most kMatchCameras.
  CameraHealth(const Calibration& calibration, const MatchOptions& options);
  ~CameraHealth();

  void watch(const HealthInput& input) noexcept;
  /// Of the last watch().
  std::span<const HealthEvent> events() const noexcept;
  CameraState state(CameraId camera) const noexcept;
  HealthReport report() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
