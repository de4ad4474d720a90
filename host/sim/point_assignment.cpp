// SPDX-License-Identifier: MIT
// Successive shortest paths over the few edges within the gate.
#include "host/sim/point_assignment.hpp"

#include <algorithm>
#include <limits>

namespace glint::sim {
namespace {

constexpr std::int32_t kNone = -1;
constexpr double kUnreached = std::numeric_limits<double>::infinity();
// Below this a shorter path is rounding, and could be followed for ever.
constexpr double kNoGain_m2 = 1e-18;

}  // namespace

void PointAssignment::solve(std::span<const Eigen::Vector3d> samples,
                            std::span<const Eigen::Vector3d> markers, double gate_m) {
  edges_.clear();
  first_edge_.assign(1, 0);
  for (const Eigen::Vector3d& sample : samples) {
    for (std::uint32_t m = 0; m < markers.size(); ++m) {
      const double cost_m2 = (sample - markers[m]).squaredNorm();
      if (cost_m2 < gate_m * gate_m) edges_.push_back({m, cost_m2});
    }
    first_edge_.push_back(static_cast<std::uint32_t>(edges_.size()));
  }
  marker_of_sample_.assign(samples.size(), kNone);
  sample_of_marker_.assign(markers.size(), kNone);
  path_cost_m2_.assign(samples.size(), kUnreached);
  taken_by_.assign(samples.size(), kNone);
  taken_marker_.assign(samples.size(), kNone);
  for (std::uint32_t s = 0; s < samples.size(); ++s)
    if (markers_near(s) > 0) insert(s, gate_m * gate_m);
}

double PointAssignment::cost_of_pair(std::uint32_t sample) const noexcept {
  for (std::uint32_t e = first_edge_[sample]; e < first_edge_[sample + 1]; ++e)
    if (static_cast<std::int32_t>(edges_[e].marker) == marker_of_sample_[sample]) return edges_[e].cost_m2;
  return 0.0;
}

void PointAssignment::insert(std::uint32_t sample, double alone_cost_m2) {
  // Who loses a marker takes another or stays alone; the cheapest end of all such chains is looked for.
  double best_m2 = alone_cost_m2;
  std::int32_t last = kNone, free_marker = kNone;  // the chain's end: that sample takes that free marker,
  std::int32_t alone = static_cast<std::int32_t>(sample);  // or this one stays alone
  queue_.assign(1, sample);
  path_cost_m2_[sample] = 0.0;
  for (std::size_t at = 0; at < queue_.size(); ++at) {
    const std::uint32_t row = queue_[at];
    const double cost_m2 = path_cost_m2_[row];
    for (std::uint32_t e = first_edge_[row]; e < first_edge_[row + 1]; ++e) {
      const Edge& edge = edges_[e];
      if (static_cast<std::int32_t>(edge.marker) == marker_of_sample_[row]) continue;
      const double taken_m2 = cost_m2 + edge.cost_m2;
      const std::int32_t owner = sample_of_marker_[edge.marker];
      if (owner == kNone) {
        if (taken_m2 < best_m2 - kNoGain_m2) {
          best_m2 = taken_m2, alone = kNone;
          last = static_cast<std::int32_t>(row), free_marker = static_cast<std::int32_t>(edge.marker);
        }
        continue;
      }
      const auto loser = static_cast<std::uint32_t>(owner);
      const double lost_m2 = taken_m2 - cost_of_pair(loser);
      if (loser == sample || !(lost_m2 < path_cost_m2_[loser] - kNoGain_m2)) continue;
      path_cost_m2_[loser] = lost_m2;
      taken_by_[loser] = static_cast<std::int32_t>(row);
      taken_marker_[loser] = static_cast<std::int32_t>(edge.marker);
      queue_.push_back(loser);
      if (lost_m2 + alone_cost_m2 < best_m2 - kNoGain_m2) {
        best_m2 = lost_m2 + alone_cost_m2;
        alone = owner;
      }
    }
  }
  // Back along the chain.
  std::int32_t row = alone != kNone ? alone : last;
  std::int32_t marker = alone != kNone ? kNone : free_marker;
  while (true) {
    const auto place = static_cast<std::size_t>(row);
    const std::int32_t lost = taken_marker_[place], taker = taken_by_[place];
    marker_of_sample_[place] = marker;
    if (marker != kNone) sample_of_marker_[static_cast<std::size_t>(marker)] = row;
    if (row == static_cast<std::int32_t>(sample)) break;
    row = taker, marker = lost;
  }
  for (const std::uint32_t reached : queue_) {
    path_cost_m2_[reached] = kUnreached;
    taken_by_[reached] = taken_marker_[reached] = kNone;
  }
}

}  // namespace glint::sim
