// SPDX-License-Identifier: MIT
// Points in, tracks with stable ids out.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/match/matcher.hpp"

namespace glint {

struct TrackOptions {
  double acceleration_sd_m_s2 = 30.0;  ///< process noise of the constant-velocity model
  double max_speed_m_s = 25.0;         ///< a new track's velocity is unknown up to this
  unsigned confirm_frames_two_views =
      3;  ///< consistent frames before a track seen by one or two cameras is published
  unsigned max_missed_frames = 9;  ///< frames without a measurement before a track ends
  void check(std::vector<std::string>& problems) const;
};

/// One row of the output: a marker measured at this exposure.
struct TrackedPoint {
  TrackId id{};
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();  ///< as triangulated, not smoothed
  Eigen::Vector3d velocity_in_world = Eigen::Vector3d::Zero();  ///< of the filter
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();      ///< of the position, from triangulation
  double residual_px = 0.0;                                     ///< reprojection rms
  std::uint32_t cameras = 0;                                    ///< bit set of cameras used
  std::uint32_t point = 0;  ///< index into the points of the update that published it
};

struct TrackCounters {
  std::uint64_t started = 0, ended = 0, published = 0, unconfirmed = 0;
};

/// Constant-velocity Kalman filter per marker, assignment by Mahalanobis distance over all tracks jointly.
/// Thread-bound. No allocation once warmed up.
class Tracker {
 public:
  explicit Tracker(const TrackOptions& options);
  ~Tracker();

  /// Moves all tracks to time `exposed` and lists where they expect their markers. Call before matching.
  void predict(Timestamp exposed, std::vector<Prediction>& predictions);

  /// Takes the points of the exposure that predict() was called for. Not to be called for an exposure in
  /// which no marker could be seen (the light was off): tracks then coast to the next one, and none counts it
  /// as a miss. Replaces `tracked` with what is published.
  void update(std::span<const Point> points, std::vector<TrackedPoint>& tracked, TrackCounters& counters);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
