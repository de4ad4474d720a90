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

#include "gpu/detector.hpp"
#include "host/base/ids.hpp"
#include "host/geometry/camera.hpp"
#include "host/match/prediction.hpp"
#include "shaders/interface/blob_record.h"

namespace glint {

inline constexpr std::size_t kMatchCameras = 32;

struct MatchOptions {
  double sigma_px = 0.0005;  ///< what centroids err by besides the noise of their pixels, per axis; a
                             ///< camera's calibration rms_px is added in quadrature
  double gate_px = 1.0;      ///< largest reprojection residual of a blob that may belong to a point, besides
                             ///< what the calibration errs by (3.5 times its rms_px, in quadrature)
  unsigned min_cameras = 2;  ///< views that a point needs
  double marker_radius_m =
      0.0;                  ///< 0: unknown; else sphere-projection bias is removed and blob sizes are checked
  double exposure_s = 0.0;  ///< light is on for; 0: too short to blur. Of blobs looked at by their pixels
  /// Blobs of one exposure whose pixels are looked at, at most; first those that need it, then, since that
  /// places them better than their centroids do, as many others as there is room for. About 15 us each.
  unsigned most_looks = 120;
  double min_range_m = 0.1;              ///< nearest point to a camera
  double max_range_m = 100.0;            ///< farthest
  std::optional<double> plane_height_m;  ///< of a rig of one camera: where the markers' centres are in z
  void check(std::vector<std::string>& problems) const;  ///< appends "match.gate_px must be > 0", ...
};

/// By how much each camera's calibration errs, per axis: its rms_px counts the length of the residual, two
/// axes together.
std::vector<double> calibration_sd_px(const Calibration& calibration);

/// One triangulated marker, or a tracked one that one camera saw.
struct Point {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  double rms_px = 0.0;                                     ///< reprojection error over the views used
  std::uint32_t views = 0;                                 ///< cameras used
  std::array<std::int32_t, kMatchCameras> blob_of_camera;  ///< index into that camera's blobs; -1: not used
  /// New, and a marker beyond doubt: no other reading of its blobs is nearly as likely, and there are three
  /// views, or two good ones that meet as chance hardly ever lets them, of a place that no other camera sees.
  bool certain = false;
  bool doubtful = false;   ///< fewer than two of its blobs show the whole of one marker
  TrackId predicted_by{};  ///< track whose prediction claimed the blobs; 0: none
  /// What the views alone say near `position_in_world`: minus half the second derivative of their
  /// log-likelihood, and its first, which is 0 where they alone decide. One view fixes two directions of
  /// three.
  Eigen::Matrix3d information_per_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_per_m = Eigen::Vector3d::Zero();
  /// By camera: blob minus calibration's projection of the position, undistorted pixels, and the blob's own
  /// variance per axis.
  std::array<Eigen::Vector2f, kMatchCameras> residual_px;
  std::array<float, kMatchCameras> noise_px2;
  float light = 0.0f;  ///< of the brightest view, in units of what is usual for its camera; 0: not known
  std::uint32_t resolved =
      0;  ///< bit set of cameras whose blob was placed by its pixels: its centroid is another one
  /// What errors of the calibration add to the covariance; 0 for one view, of which they are not known.
  Eigen::Matrix3d calibration_covariance_m2 = Eigen::Matrix3d::Zero();
};

struct MatchCounters {
  std::uint64_t blobs = 0, points = 0, unmatched_blobs = 0;
  std::uint64_t hypotheses = 0, components = 0, exact = 0,
                inexact = 0;  ///< conflict graph: solved exactly or not
  std::uint64_t hypotheses_cut =
      0;  ///< hypotheses dropped because a limit was reached: reported, never silent
  std::uint64_t resolved = 0, unresolved = 0;  ///< blobs looked at by their pixels: placed, or not explained
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
  /// images[camera]: where the blobs were found, for those that need a closer look; empty: there are none.
  void match(std::span<const std::span<const shaders::BlobRecord>> blobs,
             std::span<const Prediction> predictions, std::vector<Point>& points, MatchCounters& counters,
             std::span<const gpu::ImageView> images = {});

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace glint
