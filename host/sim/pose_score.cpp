// SPDX-License-Identifier: MIT
// Poses to bodies, and names over time.
#include "host/sim/pose_score.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "host/base/check.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kNoBody = 0xffffffffu;
constexpr unsigned kLeastMarkers = 3;

}  // namespace

PoseScore::PoseScore(const Scene& scene, double gate_m)
    : scene_(scene), gate_m_(gate_m), body_of_name_(scene.bodies(), kNoBody), found_(scene.bodies(), 0) {}

std::uint32_t PoseScore::nearest_body(const Eigen::Vector3d& origin) const noexcept {
  std::uint32_t nearest = kNoBody;
  double least_m = gate_m_;
  for (std::uint32_t b = 0; b < truth_.world_from_body.size(); ++b) {
    const double distance_m = (truth_.world_from_body[b].translation - origin).norm();
    if (!(distance_m < least_m)) continue;
    least_m = distance_m;
    nearest = b;
  }
  return nearest;
}

void PoseScore::add(std::uint64_t tick, std::span<const ScoredPose> poses) {
  scene_.truth(tick, truth_);
  std::fill(found_.begin(), found_.end(), std::uint8_t{0});
  ++counts_.ticks;
  for (const ScoredPose& pose : poses) {
    GLINT_CHECK(pose.name < body_of_name_.size());
    if (!pose.measured) continue;
    ++counts_.poses;
    counts_.ambiguous += pose.ambiguous ? 1u : 0u;
    const std::uint32_t body = nearest_body(pose.world_from_body.translation);
    if (body == kNoBody) {
      ++counts_.astray;
      continue;
    }
    found_[body] = 1;
    const Pose& truth = truth_.world_from_body[body];
    const double error_m = (pose.world_from_body.translation - truth.translation).norm();
    const double error_rad = pose.world_from_body.rotation.angularDistance(truth.rotation);
    sum_error2_m2_ += error_m * error_m;
    sum_error2_rad2_ += error_rad * error_rad;
    counts_.max_m = std::max(counts_.max_m, error_m);
    counts_.max_rad = std::max(counts_.max_rad, error_rad);
    if (pose.ambiguous) continue;
    std::uint32_t& last = body_of_name_[pose.name];
    // Bodies that differ have names of their own from the beginning.
    if (last == kNoBody && !scene_.options().bodies.identical) last = pose.name;
    if (last != kNoBody && last != body) ++counts_.silent_swaps;
    last = body;
  }
  for (std::uint32_t b = 0; b < found_.size(); ++b) {
    unsigned seen = 0;
    for (std::uint32_t m = 0; m < truth_.markers.size(); ++m)
      if (scene_.body_of(m) == b && std::popcount(truth_.markers[m].visible & truth_.delivered) >= 2) ++seen;
    if (seen < kLeastMarkers) continue;
    ++counts_.expected;
    counts_.found += found_[b];
  }
}

PoseResult PoseScore::result() const {
  PoseResult result = counts_;
  const auto placed = static_cast<double>(result.poses - result.astray);
  if (result.expected > 0)
    result.recall = static_cast<double>(result.found) / static_cast<double>(result.expected);
  if (placed > 0.0) {
    result.rms_m = std::sqrt(sum_error2_m2_ / placed);
    result.rms_rad = std::sqrt(sum_error2_rad2_ / placed);
  }
  return result;
}

}  // namespace glint
