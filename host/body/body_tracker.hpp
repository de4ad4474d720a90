// SPDX-License-Identifier: MIT
// Tracked markers in, rigid bodies with stable identities out.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/body/body_finder.hpp"
#include "host/body/body_model.hpp"
#include "host/body/body_motion.hpp"
#include "host/geometry/triangulate.hpp"

namespace glint {

struct BodyTrackerOptions {
  double marker_radius_m = 0.0;  ///< > 0: views are outlines of spheres
  BodyMotionOptions motion;
  FinderOptions finder;
  double lost_place_sd_m = 0.05;    ///< a body known worse than this is lost, and searched everywhere
  double lost_turn_sd_rad = 0.6;    ///< or this, about any axis
  unsigned max_missed_frames = 45;  ///< frames without two markers before it is lost in any case
  unsigned confirm_frames = 3;  ///< consistent frames before a body found by three markers of more is shown
  double ambiguity_log_odds = 6.9;  ///< 1000 : 1; two identities less sure than that are ambiguous
  double carried_speed_m_s = 2.0;   ///< how fast a lost body is taken elsewhere
  void check(std::vector<std::string>& problems) const;
};

/// Where a body expects one of its markers.
struct ExpectedMarker {
  std::uint32_t body = 0, marker = 0;
  TrackId track{};  ///< 0: none yet
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

/// One marker of this exposure.
struct MarkerSample {
  TrackId track{};
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  std::span<const Observation> views;  ///< borrowed for the call; at most one a camera
};

enum class BodyKind : std::uint8_t { Measured, Predicted };

/// Why it is not certain which body it is.
enum class BodyDoubt : std::uint8_t {
  None,
  Crossing,    ///< it came so near to an identical body that either could be the other
  FoundAgain,  ///< it was lost and could be an identical body
  Symmetric,   ///< it looks like itself when turned: which body is certain, its orientation is not
};

/// One row of the output. Predicted: fewer than two markers were seen.
struct TrackedBody {
  std::uint32_t body = 0;
  Pose world_from_body;
  Matrix6 covariance = Matrix6::Zero();  ///< rotation vector in the world, then translation
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();  ///< of the body's origin
  Eigen::Vector3d angular_velocity_in_world = Eigen::Vector3d::Zero();
  BodyKind kind = BodyKind::Measured;
  std::uint32_t age_frames = 0;  ///< since it was measured
  unsigned markers = 0, views = 0;
  double rms_px = 0.0;  ///< of the views; 0: none
  bool ambiguous = false;
  std::uint32_t ambiguous_with = 0;  ///< the other body, or itself (Symmetric)
  BodyDoubt doubt = BodyDoubt::None;
};

enum class BodyEventKind : std::uint8_t {
  Found,
  Lost,
  Ambiguous,  ///< with `other`, for the reason `doubt`
  Kept,       ///< no longer ambiguous: it has been itself all the time
  Exchanged,  ///< no longer ambiguous: what was given out as `body` since was `other`; from now on it is
              ///< right
};

struct BodyEvent {
  BodyEventKind kind = BodyEventKind::Found;
  std::uint32_t body = 0, other = 0;
  BodyDoubt doubt = BodyDoubt::None;
};

struct BodyCounters {
  std::uint64_t found = 0, lost = 0, ambiguous = 0, kept = 0, exchanged = 0;
  std::uint64_t let_go = 0;     ///< samples that no longer fitted their body
  std::uint64_t acquired = 0;   ///< samples taken because a body expected a marker there
  std::uint64_t contested = 0;  ///< samples that two markers expected alike, left alone for a frame
  std::uint64_t jumps = 0;      ///< bodies whose motion began anew: a blow, or a bounce
  std::uint64_t searches = 0;
  FinderCounters finder;
};

/// Life of bodies: found among samples, followed by the tracks of their markers, predicted while hidden,
/// searched when lost. A pose is fitted to the views of all markers with the predicted pose as prior; a
/// sample that does not fit the rigid body is let go, whatever its track says. Bodies of the same shape are
/// given out jointly, and where two ways of doing so are too close both bodies say so until something decides
/// it. Thread-bound. No allocation once warm.
class BodyTracker {
 public:
  /// Throws Error for models that cannot be tracked.
  explicit BodyTracker(std::vector<BodyModel> models, const BodyTrackerOptions& options = {});
  ~BodyTracker();

  /// Moves all bodies to time `exposed` and replaces `expected` by where they expect their markers.
  void predict(Timestamp exposed, std::vector<ExpectedMarker>& expected);
  /// Takes the samples of the exposure that predict() was called for; replaces `bodies`. Bodies that are lost
  /// or not yet confirmed are not listed.
  void update(std::span<const MarkerSample> samples, std::vector<TrackedBody>& bodies,
              BodyCounters& counters);
  /// What happened in the last update().
  std::span<const BodyEvent> events() const noexcept;
  /// A person says that `body` is what it is given out as: ends its ambiguity.
  void settle(std::uint32_t body) noexcept;
  const std::vector<BodyModel>& models() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
