// SPDX-License-Identifier: MIT
// The plain method that others are compared with: correspondence frame by frame, nearest-neighbour ids.
#pragma once

#include <cstdint>
#include <queue>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/geometry/camera.hpp"
#include "host/geometry/triangulate.hpp"
#include "host/sim/identity_score.hpp"
#include "shaders/interface/blob_record.h"

namespace glint::identity {

/// What a careful person writes in an afternoon. All pairs of rays that meet are completed by the nearest
/// blob in each other camera, triangulated on the reprojection error, and taken best first (more views, then
/// smaller residual), each blob once; what lost a blob is completed anew from those still free. No prediction
/// takes part. Ids: nearest pair of old place and new point first, up to 0.15 m, forgotten after 9 frames.
/// Thread-bound.
class PlainTracker {
 public:
  PlainTracker(const Calibration& calibration, double marker_radius_m);

  /// blobs[camera], with x_undist, y_undist. Replaces `samples`, which have no covariance.
  void track(std::span<const std::span<const shaders::BlobRecord>> blobs,
             std::vector<IdentitySample>& samples);

 private:
  static constexpr std::int32_t kNoBlob = -1;
  struct Ray {
    Eigen::Vector2d normalized;
    Eigen::Vector3d direction;
    bool used = false;
  };
  struct Candidate {
    std::uint32_t camera_a = 0, blob_a = 0, camera_b = 0, blob_b = 0;
    Eigen::Vector3d start_in_world, position_in_world;
    std::uint32_t views = 0;
    double rms_px = 0.0;
    std::vector<std::int32_t> blob_of_camera;
    bool operator<(const Candidate& better) const noexcept {
      return views != better.views ? views < better.views : rms_px > better.rms_px;
    }
  };
  struct Known {
    std::uint32_t id = 0, missed = 0;
    Eigen::Vector3d position_in_world;
  };
  void pair_up(std::uint32_t a, std::uint32_t b);
  bool complete(Candidate& candidate) const;
  std::int32_t nearest_blob(std::uint32_t camera, const Eigen::Vector3d& point_in_world) const;
  bool fits(Candidate& candidate) const;
  void give_ids(std::vector<IdentitySample>& samples);

  std::vector<Camera> cameras_;
  double marker_radius_m_, gate_px_;
  std::vector<std::vector<Ray>> rays_;
  std::priority_queue<Candidate> candidates_;
  std::vector<Known> known_;
  std::uint32_t next_id_ = 1;
};

}  // namespace glint::identity
