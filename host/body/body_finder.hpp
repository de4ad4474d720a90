// SPDX-License-Identifier: MIT
// Finds bodies among points that nobody has named, from any pose.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/body/body_pose_fit.hpp"
#include "host/match/set_packing.hpp"

namespace glint {

inline constexpr std::uint32_t kMarkerNotSeen = std::numeric_limits<std::uint32_t>::max();

struct FinderPoint {
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
};

struct FinderOptions {
  unsigned min_markers = 3;        ///< of a body that must be among the points
  double max_missing_share = 0.5;  ///< fewer than this share of a body's markers may be missing
  double point_floor_m = 2e-4;     ///< added to the points' standard deviations, which do not know all errors
  double detected = 0.9;           ///< how often a marker is among the points; only its logarithm counts
  double min_score = 3.0;          ///< log-likelihood by which a body must beat a chance meeting of points
  void check(std::vector<std::string>& problems) const;
};

/// A shape that was found; which of several identical bodies it is, its finder does not know.
struct FoundBody {
  std::uint32_t shape = 0;
  Pose world_from_shape;
  Matrix6 covariance = Matrix6::Zero();
  std::array<std::uint32_t, kBodyMarkers> point_of_marker{};  ///< kMarkerNotSeen: not seen
  unsigned markers = 0;
  double score = 0.0;       ///< log-likelihood ratio: this body, or as many points of nobody
  double runner_up = 0.0;   ///< best other explanation of any of its points by a body; 0: none
  bool relabelled = false;  ///< that other explanation is the same body, turned
};

struct FinderCounters {
  std::uint64_t candidates = 0, mirrored = 0;  ///< mirrored: mirror images of bodies, which are none
  std::uint64_t candidates_cut = 0;            ///< not looked at because there were too many
  SetPacking::Counters packing;
};

/// What to look for: one shape, and how many bodies of it there are to find.
struct WantedShape {
  std::vector<Eigen::Vector3d> markers_in_shape;
  double marker_sd_m = kDefaultMarkerSd_m;
};

/// Pairs of points are looked up in a table of all pair distances of all shapes, extended to triples,
/// verified by the pose and all other markers, and scored by likelihood; the best disjoint set of bodies is
/// chosen. Each triple of points is looked at once per labelling, and points are neighbours only within a
/// body's diameter, so that the cost is near linear in points and in shapes. Where a body lacks
/// markers its mirror image is looked for, too, and what is better explained by that is refused. Keeps its
/// memory. Thread-bound.
class BodyFinder {
 public:
  explicit BodyFinder(std::vector<WantedShape> shapes, const FinderOptions& options = {});

  /// At most wanted[shape] bodies of each shape; replaces `found`, best first.
  void find(std::span<const FinderPoint> points, std::span<const std::uint32_t> wanted,
            std::vector<FoundBody>& found, FinderCounters& counters);

 private:
  struct TableEntry {
    double distance_m;
    std::uint32_t shape, i, j;
  };
  struct Neighbour {
    double distance_m;
    std::uint32_t point;
  };
  struct Candidate {
    FoundBody body;
  };

  void collect_neighbours(std::span<const FinderPoint> points, double reach_m);
  void extend_pair(std::span<const FinderPoint> points, std::uint32_t a, const Neighbour& b,
                   const TableEntry& entry, bool turned, FinderCounters& counters);
  void consider(std::span<const FinderPoint> points, std::uint32_t shape,
                const std::array<std::uint32_t, 3>& markers, const std::array<std::uint32_t, 3>& at,
                FinderCounters& counters);
  bool covered(std::uint32_t shape, const std::array<std::uint32_t, 3>& markers,
               const std::array<std::uint32_t, 3>& at) const noexcept;
  bool refine(std::span<const FinderPoint> points, FoundBody& body) const noexcept;
  std::uint32_t nearest(std::span<const FinderPoint> points, std::uint32_t from, double distance_m,
                        const Eigen::Vector3d& at, double reach_m) const noexcept;
  double score_of(std::span<const FinderPoint> points, FoundBody& body) const noexcept;
  void collect_candidates(std::span<const FinderPoint> points, FinderCounters& counters);
  void choose(std::span<const FinderPoint> points, std::span<const std::uint32_t> wanted,
              FinderCounters& counters);
  void hand_over(std::span<const std::uint32_t> wanted, std::vector<FoundBody>& found,
                 FinderCounters& counters);
  unsigned least_markers(std::uint32_t shape) const noexcept;

  const std::size_t real_;
  std::vector<WantedShape> shapes_;  // the real ones, then their mirror images
  FinderOptions options_;
  std::vector<TableEntry> table_;           // ascending distances
  std::vector<std::uint32_t> first_entry_;  // by bin
  std::vector<double> diameter_m_;
  double largest_sd_m_ = 0.0;

  double log_density_ = 0.0, log_volume_ = 0.0;
  std::vector<double> sd_m_;  // of each point, along its worst axis
  std::vector<std::uint32_t> by_x_, first_neighbour_;
  std::vector<Neighbour> neighbours_;  // of each point, ascending distances
  std::vector<Candidate> candidates_;
  std::vector<std::uint32_t> head_;  // by shape and point: newest candidate that holds the point
  std::vector<std::uint32_t> link_next_, link_candidate_;
  SetPacking packing_;
  std::vector<std::uint32_t> elements_, chosen_, left_;
  std::vector<std::uint8_t> look_for_;  // by shape
};

}  // namespace glint
