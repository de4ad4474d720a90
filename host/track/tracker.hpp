// SPDX-License-Identifier: MIT
// Points in, tracks with stable ids out.
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/match/matcher.hpp"
#include "host/track/doubts.hpp"

namespace glint {

struct TrackOptions {
  double acceleration_sd_m_s2 = 30.0;  ///< usual acceleration of the markers: the scale of all motion models
  double max_speed_m_s = 25.0;         ///< a new track's velocity is unknown up to this
  unsigned confirm_frames_two_views =
      3;  ///< consistent frames before a track seen by one or two cameras is published
  unsigned max_missed_frames = 9;  ///< frames in which no camera sees the marker before its track ends
  double max_predicted_sd_m =
      0.005;  ///< a sample that no two cameras measured is published up to this uncertainty
  void check(std::vector<std::string>& problems) const;
};

/// What a sample rests on.
enum class SampleKind : std::uint8_t {
  Measured,    ///< two or more cameras, in this exposure
  SingleView,  ///< one camera, and where the marker was expected
  Predicted,   ///< no camera: only where it was expected
};

inline constexpr std::uint32_t kNoPoint = std::numeric_limits<std::uint32_t>::max();

/// One row of the output: a marker at this exposure.
struct TrackedPoint {
  TrackId id{};
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 =
      Eigen::Matrix3d::Zero();     ///< of the position, errors of the calibration included
  double residual_px = 0.0;        ///< reprojection rms; 0 if predicted
  std::uint32_t cameras = 0;       ///< bit set of cameras used
  std::uint32_t point = kNoPoint;  ///< index into the points of the update that published it; predicted: none
  SampleKind kind = SampleKind::Measured;
  std::uint32_t age_frames = 0;  ///< since two cameras measured it; 0: now
  TrackId ambiguous_with{};  ///< it may be the marker of that track, and that track this one's; 0: no doubt
};

struct TrackCounters {
  std::uint64_t started = 0, ended = 0, published = 0, unconfirmed = 0;
  std::uint64_t ambiguous = 0;  ///< pairs that could not be told apart for a while, of which:
  std::uint64_t kept = 0, swapped = 0, unresolved = 0;  ///< as in IdentityEvent; the rest is open yet
};

/// Motion models side by side for each marker (host/track/motion.hpp), corrected by whatever the cameras saw
/// of it. For each marker and camera it learns, too, by how much the calibration errs where the marker is, so
/// that predictions in the images are as sharp as the blobs and not as blunt as the calibration.
/// Thread-bound. No allocation once warmed up.
class Tracker {
 public:
  /// calibration_sd_px: by camera, per axis, what the calibration errs by (calibration_sd_px()); empty:
  /// exact.
  explicit Tracker(const TrackOptions& options, std::span<const double> calibration_sd_px = {});
  ~Tracker();

  /// Moves all tracks to time `exposed` and lists where they expect their markers. Call before matching.
  void predict(Timestamp exposed, std::vector<Prediction>& predictions);

  /// `predictions` borrow from the tracker until update(). Takes the points of the exposure that predict()
  /// was called for. Not to be called for an exposure in which no marker could be seen (the light was off):
  /// tracks then coast to the next one, and none counts it as a miss. Replaces `tracked` with what is
  /// published.
  void update(std::span<const Point> points, std::vector<TrackedPoint>& tracked, TrackCounters& counters);
  /// Of the last update().
  std::span<const IdentityEvent> events() const noexcept;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
