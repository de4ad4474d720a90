// SPDX-License-Identifier: MIT
// Recall, ghosts, errors and their ratio to the Cramer-Rao bound.
#include "host/sim/score.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace glint {
namespace {

// Median of |e| / sqrt(E e^2) for an isotropic normal error in 3D: sqrt(median of chi-squared(3) / 3).
constexpr double kNormalMedian = 0.88805;

constexpr std::int32_t kGhost = -1, kDoubled = -2, kNone = -1;

double ratio_of(std::uint64_t part, std::uint64_t whole) noexcept {
  return whole == 0 ? 0.0 : static_cast<double>(part) / static_cast<double>(whole);
}
double root_mean(double sum, std::uint64_t count) noexcept {
  return count == 0 ? 0.0 : std::sqrt(sum / static_cast<double>(count));
}

}  // namespace

Score::Score(const Scene& scene, const ScoreOptions& options)
    : scene_(scene),
      options_(options),
      bound_(scene),
      point_of_marker_(scene.markers()),
      last_id_(scene.markers()) {
  pairs_.reserve(std::size_t{4} * scene.markers());
  marker_of_point_.reserve(std::size_t{4} * scene.markers());
}

void Score::add(std::uint64_t tick, std::span<const ScoredPoint> points) {
  scene_.truth(tick, truth_);
  assign(points);
  ++counts_.ticks;
  counts_.points += points.size();
  for (std::size_t m = 0; m < truth_.markers.size(); ++m) {
    const bool found = point_of_marker_[m] != kNone;
    if (std::popcount(truth_.markers[m].clean) >= 2) {
      ++counts_.expected;
      counts_.found += found ? 1u : 0u;
    }
    if (std::popcount(truth_.markers[m].visible & truth_.delivered) >= 2) {
      ++counts_.expected_visible;
      counts_.found_visible += found ? 1u : 0u;
    }
  }
  for (const std::int32_t marker : marker_of_point_) {
    counts_.ghosts += marker == kGhost ? 1u : 0u;
    counts_.doubled += marker == kDoubled ? 1u : 0u;
  }
  count_errors(tick, points);
}

void Score::assign(std::span<const ScoredPoint> points) {
  pairs_.clear();
  marker_of_point_.assign(points.size(), kGhost);
  std::fill(point_of_marker_.begin(), point_of_marker_.end(), kNone);
  for (std::uint32_t p = 0; p < points.size(); ++p) {
    for (std::uint32_t m = 0; m < truth_.markers.size(); ++m) {
      const double distance = (points[p].position_in_world - truth_.markers[m].position_in_world).norm();
      if (distance < options_.gate_m)
        pairs_.push_back({distance, p, m});  // false for a point that is not a number
    }
  }
  std::sort(pairs_.begin(), pairs_.end(),
            [](const Pair& a, const Pair& b) { return a.distance_m < b.distance_m; });
  for (const Pair& pair : pairs_) {
    std::int32_t& marker = marker_of_point_[pair.point];
    if (marker >= 0) continue;
    if (point_of_marker_[pair.marker] != kNone) {
      marker = kDoubled;
      continue;
    }
    marker = static_cast<std::int32_t>(pair.marker);
    point_of_marker_[pair.marker] = static_cast<std::int32_t>(pair.point);
  }
}

void Score::count_errors(std::uint64_t tick, std::span<const ScoredPoint> points) {
  const bool with_bound = options_.bound_every > 0 && tick % options_.bound_every == 0;
  for (std::uint32_t m = 0; m < point_of_marker_.size(); ++m) {
    if (point_of_marker_[m] == kNone) continue;
    const ScoredPoint& point = points[static_cast<std::size_t>(point_of_marker_[m])];
    const MarkerTruth& marker = truth_.markers[m];
    const double error2 = (point.position_in_world - marker.position_in_world).squaredNorm();
    sum_error2_ += error2;
    counts_.max_m = std::max(counts_.max_m, std::sqrt(error2));
    errors_.add(std::sqrt(error2));
    if (point.id != 0) {
      if (last_id_[m] != 0 && last_id_[m] != point.id) ++counts_.id_switches;
      last_id_[m] = point.id;
    }
    if ((point.cameras & ~marker.clean) != 0) continue;
    sum_clean_error2_ += error2;
    ++clean_points_;
    if (!with_bound) continue;
    const double bound2 = bound_.variance_m2(truth_, m);
    if (!std::isfinite(bound2)) continue;
    sum_bounded_error2_ += error2;
    sum_bound2_ += bound2;
    ratios_.add(std::sqrt(error2 / bound2));
    ++bounded_points_;
  }
}

ScoreResult Score::result() const {
  ScoreResult result = counts_;
  const std::uint64_t matched = result.points - result.ghosts - result.doubled;
  result.recall = ratio_of(result.found, result.expected);
  result.recall_visible = ratio_of(result.found_visible, result.expected_visible);
  result.ghost_rate = ratio_of(result.ghosts, result.points);
  result.rms_m = root_mean(sum_error2_, matched);
  result.median_m = errors_.median();
  result.rms_clean_m = root_mean(sum_clean_error2_, clean_points_);
  result.bound_rms_m = root_mean(sum_bound2_, bounded_points_);
  result.ratio = bounded_points_ == 0 ? 0.0 : std::sqrt(sum_bounded_error2_ / sum_bound2_);
  result.median_ratio = ratios_.median() / kNormalMedian;
  return result;
}

}  // namespace glint
