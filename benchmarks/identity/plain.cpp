// SPDX-License-Identifier: MIT
// Best-first correspondence with exclusivity and a reprojection gate.
#include "benchmarks/identity/plain.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "gpu/detector.hpp"

namespace glint::identity {
namespace {

constexpr double kNearest_m = 0.1;           // to a camera
constexpr double kSmallestAngle_rad = 0.02;  // between two rays
constexpr double kFarthestStep_m = 0.15;     // 10 m/s at 90 Hz, and a little
constexpr std::uint32_t kMostMissed = 9;

double gate_of(const Calibration& calibration) {
  double worst_px = 0.0;
  for (const CameraCalibration& camera : calibration.cameras) worst_px = std::max(worst_px, camera.rms_px);
  return 1.0 + 2.0 * worst_px;
}

}  // namespace

PlainTracker::PlainTracker(const Calibration& calibration, double marker_radius_m)
    : marker_radius_m_(marker_radius_m), gate_px_(gate_of(calibration)), rays_(calibration.cameras.size()) {
  for (const CameraCalibration& camera : calibration.cameras) cameras_.emplace_back(camera);
}

void PlainTracker::track(std::span<const std::span<const shaders::BlobRecord>> blobs,
                         std::vector<IdentitySample>& samples) {
  samples.clear();
  for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
    rays_[c].clear();
    for (const shaders::BlobRecord& blob : blobs[c]) {
      if ((blob.flags & shaders::kBlobNotInvertible) != 0) continue;
      const Eigen::Vector2d normalized(static_cast<double>(blob.x_undist),
                                       static_cast<double>(blob.y_undist));
      rays_[c].push_back({normalized, cameras_[c].direction_in_world(normalized), false});
    }
  }
  for (std::uint32_t a = 0; a < cameras_.size(); ++a)
    for (std::uint32_t b = a + 1; b < cameras_.size(); ++b) pair_up(a, b);
  while (!candidates_.empty()) {
    Candidate best = candidates_.top();
    candidates_.pop();
    if (rays_[best.camera_a][best.blob_a].used || rays_[best.camera_b][best.blob_b].used) continue;
    bool free = true;
    for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
      const std::int32_t blob = best.blob_of_camera[c];
      free = free && (blob == kNoBlob || !rays_[c][static_cast<std::size_t>(blob)].used);
    }
    if (!free) {
      if (complete(best)) candidates_.push(std::move(best));
      continue;
    }
    IdentitySample sample;
    sample.position_in_world = best.position_in_world;
    for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
      if (best.blob_of_camera[c] == kNoBlob) continue;
      rays_[c][static_cast<std::size_t>(best.blob_of_camera[c])].used = true;
      sample.cameras |= 1u << c;
    }
    samples.push_back(sample);
  }
  give_ids(samples);
}

void PlainTracker::pair_up(std::uint32_t a, std::uint32_t b) {
  const Eigen::Vector3d base = cameras_[b].position_in_world() - cameras_[a].position_in_world();
  const double pixel_a = gate_px_ / std::abs(cameras_[a].calibration().fx_px);
  const double pixel_b = gate_px_ / std::abs(cameras_[b].calibration().fx_px);
  for (std::uint32_t i = 0; i < rays_[a].size(); ++i) {
    const Eigen::Vector3d& from_a = rays_[a][i].direction;
    const Eigen::Vector3d base_by_a = base.cross(from_a);
    for (std::uint32_t j = 0; j < rays_[b].size(); ++j) {
      const Eigen::Vector3d& from_b = rays_[b][j].direction;
      const Eigen::Vector3d normal = from_a.cross(from_b);
      const double sine2 = normal.squaredNorm();
      if (sine2 < kSmallestAngle_rad * kSmallestAngle_rad) continue;
      const double depth_a = base.cross(from_b).dot(normal) / sine2, depth_b = base_by_a.dot(normal) / sine2;
      if (depth_a < kNearest_m || depth_b < kNearest_m) continue;
      const double reach_m = depth_a * pixel_a + depth_b * pixel_b, apart = base.dot(normal);
      if (apart * apart > reach_m * reach_m * sine2) continue;
      Candidate candidate{a, i, b, j, {}, {}, 0, 0.0, {}};
      candidate.start_in_world = 0.5 * (cameras_[a].position_in_world() + depth_a * from_a +
                                        cameras_[b].position_in_world() + depth_b * from_b);
      if (complete(candidate)) candidates_.push(std::move(candidate));
    }
  }
}

bool PlainTracker::complete(Candidate& candidate) const {
  candidate.blob_of_camera.assign(cameras_.size(), kNoBlob);
  for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
    if (c == candidate.camera_a) {
      candidate.blob_of_camera[c] = static_cast<std::int32_t>(candidate.blob_a);
    } else if (c == candidate.camera_b) {
      candidate.blob_of_camera[c] = static_cast<std::int32_t>(candidate.blob_b);
    } else {
      candidate.blob_of_camera[c] = nearest_blob(c, candidate.start_in_world);
    }
  }
  return fits(candidate);
}

std::int32_t PlainTracker::nearest_blob(std::uint32_t camera, const Eigen::Vector3d& point_in_world) const {
  const Eigen::Vector3d point = cameras_[camera].in_camera(point_in_world);
  if (point.z() < kNearest_m) return kNoBlob;
  const Eigen::Vector2d seen = point.head<2>() / point.z();
  // The start comes from two views only: a view that fits in the end may lie twice as far from it.
  const double reach = 2.0 * gate_px_ / std::abs(cameras_[camera].calibration().fx_px);
  double nearest2 = reach * reach;
  std::int32_t nearest = kNoBlob;
  for (std::size_t i = 0; i < rays_[camera].size(); ++i) {
    const double distance2 = (rays_[camera][i].normalized - seen).squaredNorm();
    if (rays_[camera][i].used || distance2 > nearest2) continue;
    nearest2 = distance2;
    nearest = static_cast<std::int32_t>(i);
  }
  return nearest;
}

bool PlainTracker::fits(Candidate& candidate) const {
  while (true) {
    std::array<Observation, gpu::kMaxCameras> views;
    std::array<std::uint32_t, gpu::kMaxCameras> camera_of_view{};
    std::size_t count = 0;
    for (std::uint32_t c = 0; c < cameras_.size(); ++c) {
      if (candidate.blob_of_camera[c] == kNoBlob) continue;
      camera_of_view[count] = c;
      views[count].camera = &cameras_[c];
      views[count].normalized = rays_[c][static_cast<std::size_t>(candidate.blob_of_camera[c])].normalized;
      ++count;
    }
    const std::span<const Observation> used(views.data(), count);
    const auto point = triangulate(used, {marker_radius_m_, kSmallestAngle_rad});
    if (!point) return false;
    double worst_px = 0.0, worst_added_px = 0.0;
    std::uint32_t worst_added = 0;
    for (std::size_t v = 0; v < count; ++v) {
      const double off_px =
          reprojection_residual_px(views[v], point->position_in_world, marker_radius_m_).norm();
      worst_px = std::max(worst_px, off_px);
      const std::uint32_t c = camera_of_view[v];
      if (c == candidate.camera_a || c == candidate.camera_b || off_px <= worst_added_px) continue;
      worst_added_px = off_px;
      worst_added = c;
    }
    if (worst_px <= gate_px_) {
      candidate.position_in_world = point->position_in_world;
      candidate.views = static_cast<std::uint32_t>(count);
      candidate.rms_px = point->rms_px;
      return true;
    }
    if (count == 2) return false;
    candidate.blob_of_camera[worst_added] = kNoBlob;
  }
}

void PlainTracker::give_ids(std::vector<IdentitySample>& samples) {
  struct Step {
    double length_m;
    std::size_t sample, known;
  };
  std::vector<Step> steps;
  for (std::size_t s = 0; s < samples.size(); ++s) {
    for (std::size_t k = 0; k < known_.size(); ++k) {
      const double length_m = (samples[s].position_in_world - known_[k].position_in_world).norm();
      if (length_m < kFarthestStep_m) steps.push_back({length_m, s, k});
    }
  }
  std::sort(steps.begin(), steps.end(), [](const Step& a, const Step& b) { return a.length_m < b.length_m; });
  for (Known& known : known_) ++known.missed;
  for (const Step& step : steps) {
    Known& known = known_[step.known];
    if (samples[step.sample].id != 0 || known.missed == 0) continue;
    samples[step.sample].id = known.id;
    known.missed = 0;
    known.position_in_world = samples[step.sample].position_in_world;
  }
  std::erase_if(known_, [](const Known& known) { return known.missed > kMostMissed; });
  for (IdentitySample& sample : samples) {
    if (sample.id != 0) continue;
    sample.id = next_id_++;
    known_.push_back({sample.id, 0, sample.position_in_world});
  }
}

}  // namespace glint::identity
