// SPDX-License-Identifier: MIT
// How good a tracker's points are, against the truth.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/sim/bound.hpp"
#include "host/sim/log_histogram.hpp"
#include "host/sim/scene.hpp"

namespace glint {

/// One point of a tracker's output.
struct ScoredPoint {
  std::uint32_t id = 0;  ///< of its track; 0: none
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  std::uint32_t cameras = 0;  ///< bit set of cameras used
};

struct ScoreOptions {
  double gate_m = 0.01;           ///< a point farther than this from every marker is a ghost
  std::uint64_t bound_every = 8;  ///< ticks; the Cramer-Rao bound costs as much as rendering
};

/// Ratios are 0 where nothing was counted.
struct ScoreResult {
  std::uint64_t ticks = 0, points = 0;
  std::uint64_t expected = 0, found = 0;  ///< markers clean in at least two cameras; those with a point
  std::uint64_t expected_visible = 0,
                found_visible = 0;  ///< the same for visible in two delivered frames, merged or not
  std::uint64_t ghosts = 0;         ///< points with no marker within the gate
  std::uint64_t doubled = 0;        ///< points within the gate of a marker that has a nearer point already
  std::uint64_t id_switches = 0;    ///< a marker's point has another id than its last one
  double recall = 0.0, recall_visible = 0.0, ghost_rate = 0.0;
  double rms_m = 0.0, max_m = 0.0;  ///< 3D error of all points that were given a marker
  double median_m = 0.0;
  double rms_clean_m = 0.0;  ///< only markers clean in every camera that the point used
  /// Of the clean points at the ticks where the bound was computed: its root mean square, the ratio of the
  /// points' RMS error to it, and the median error over bound, divided by what it would be for normal errors
  /// at the bound. The bound is that of one exposure; tracks, which know more, may be below it.
  double bound_rms_m = 0.0, ratio = 0.0, median_ratio = 0.0;
};

/// Assigns each tick's points to markers, nearest pair first. Thread-bound; no allocation once the largest
/// tick was seen.
class Score {
 public:
  /// `scene` must outlive the score. Points are wanted for every tick of the run, in order.
  explicit Score(const Scene& scene, const ScoreOptions& options = {});
  void add(std::uint64_t tick, std::span<const ScoredPoint> points);
  ScoreResult result() const;

 private:
  struct Pair {
    double distance_m = 0.0;
    std::uint32_t point = 0, marker = 0;
  };
  void assign(std::span<const ScoredPoint> points);
  void count_errors(std::uint64_t tick, std::span<const ScoredPoint> points);

  const Scene& scene_;
  ScoreOptions options_;
  PositionBound bound_;
  TickTruth truth_;
  std::vector<Pair> pairs_;
  std::vector<std::int32_t> marker_of_point_;  // -1: ghost, -2: the marker has a nearer point
  std::vector<std::int32_t> point_of_marker_;  // -1: none
  std::vector<std::uint32_t> last_id_;         // per marker; 0: none yet
  ScoreResult counts_;
  double sum_error2_ = 0.0, sum_clean_error2_ = 0.0, sum_bounded_error2_ = 0.0, sum_bound2_ = 0.0;
  std::uint64_t clean_points_ = 0, bounded_points_ = 0;
  sim::LogHistogram errors_, ratios_;
};

}  // namespace glint
