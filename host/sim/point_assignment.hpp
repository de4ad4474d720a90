// SPDX-License-Identifier: MIT
// Which sample is which marker, by position alone: the best one-to-one assignment within a gate.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

namespace glint::sim {

/// Minimises the sum of squared distances of the pairs plus gate^2 for every sample left alone: exactly, by
/// one shortest augmenting path per sample (Ahuja, Magnanti and Orlin, Network Flows, 1993, ch. 9 and 12). No
/// allocation once the largest input was seen.
class PointAssignment {
 public:
  /// Positions that are not numbers are near nothing.
  void solve(std::span<const Eigen::Vector3d> samples, std::span<const Eigen::Vector3d> markers,
             double gate_m);

  /// -1: none.
  std::int32_t marker_of(std::size_t sample) const noexcept { return marker_of_sample_[sample]; }
  std::int32_t sample_of(std::size_t marker) const noexcept { return sample_of_marker_[marker]; }
  /// How many markers lie within the gate of that sample.
  std::uint32_t markers_near(std::size_t sample) const noexcept {
    return first_edge_[sample + 1] - first_edge_[sample];
  }

 private:
  struct Edge {
    std::uint32_t marker = 0;
    double cost_m2 = 0.0;
  };
  void insert(std::uint32_t sample, double alone_cost_m2);
  double cost_of_pair(std::uint32_t sample) const noexcept;

  std::vector<Edge> edges_;  // of sample s: first_edge_[s] .. first_edge_[s + 1]
  std::vector<std::uint32_t> first_edge_;
  std::vector<std::int32_t> marker_of_sample_, sample_of_marker_;
  // Of the augmenting path: cost at which a sample would lose its marker, which sample took it, which marker
  // that sample took.
  std::vector<double> path_cost_m2_;
  std::vector<std::int32_t> taken_by_, taken_marker_;
  std::vector<std::uint32_t> queue_;
};

}  // namespace glint::sim
