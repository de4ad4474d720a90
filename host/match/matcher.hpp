// SPDX-License-Identifier: MIT
// Blobs of several cameras in, 3D points out: correspondence over all cameras jointly.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/geometry/camera.hpp"
#include "shaders/interface/blob_record.h"

namespace glint {

inline constexpr std::size_t kMatchCameras = 32;

struct MatchOptions {
  double sigma_px = 0.05;    ///< standard deviation, per axis, of a good blob's centroid; a camera's
                             ///< calibration rms_px is added to it in quadrature
  double gate_px = 1.0;      ///< largest reprojection residual of a blob that may belong to a point
  unsigned min_cameras = 2;  ///< views that a point needs
  double marker_radius_m =
      0.0;  ///< 0: unknown; else sphere-projection bias is removed and blob sizes are checked
  double min_range_m = 0.1;              ///< nearest point to a camera
  double max_range_m = 100.0;            ///< farthest
  std::optional<double> plane_height_m;  ///< of a rig of one camera: where the markers' centres are in z
  void check(std::vector<std::string>& problems) const;  ///< appends "match.gate_px must be > 0", ...
};

/// Where a track expects its marker at the exposure that is being matched.
struct Prediction {
  TrackId track{};
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Identity();
};

/// One triangulated marker.
struct Point {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  double rms_px = 0.0;                                     ///< reprojection error over the views used
  std::uint32_t views = 0;                                 ///< cameras used
  std::array<std::int32_t, kMatchCameras> blob_of_camera;  ///< index into that camera's blobs; -1: not used
  TrackId predicted_by{};  ///< track whose prediction claimed the blobs; 0: none
};

struct MatchCounters {
  std::uint64_t blobs = 0, points = 0, unmatched_blobs = 0;
  std::uint64_t hypotheses = 0, components = 0, exact = 0,
                inexact = 0;  ///< conflict graph: solved exactly or not
  std::uint64_t hypotheses_cut =
      0;  ///< hypotheses dropped because a limit was reached: reported, never silent
  std::uint64_t held_back =
      0;  ///< pairs not made into points: only two views, one of which looks merged or cut off
};

/// Thread-bound. No allocation in match() once it has seen its largest input.
class Matcher {
 public:
  /// Cameras in rig order, at most kMatchCameras. With plane_height_m, exactly one: every blob of it that
  /// looks at the plane is a point of its own, of one view. Throws Error where that cannot work.
  Matcher(const Calibration& calibration, const MatchOptions& options);
  ~Matcher();

  /// blobs[camera] lists that camera's blobs with x_undist, y_undist filled. Replaces `points`; adds to
  /// `counters`.
  void match(std::span<const std::span<const shaders::BlobRecord>> blobs,
             std::span<const Prediction> predictions, std::vector<Point>& points, MatchCounters& counters);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
