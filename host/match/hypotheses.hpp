// SPDX-License-Identifier: MIT
// Hypotheses "these blobs are one marker", found, scored and kept.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "host/geometry/triangulate.hpp"
#include "host/match/blob_table.hpp"
#include "host/match/blob_tuple.hpp"
#include "host/match/pair_search.hpp"
#include "host/match/seen_set.hpp"

namespace glint {

struct Hypothesis {
  Triangulated point;
  double score = 0.0;  ///< log-likelihood ratio: one marker against that many blobs of clutter
  std::uint32_t first = 0, count = 0;
  bool doubtful = false;  ///< at most one of its blobs looks like one whole marker
  bool complete = false;  ///< all of them do, and no other camera should see it
};

class Hypotheses {
 public:
  /// All borrowed for the life of this.
  Hypotheses(std::span<const Camera> cameras, const MatchOptions& options, const BlobTable& table);

  /// Forgets everything; clutter densities are taken from the blobs that are free now. A tuple with fewer
  /// views than `min_views` is not kept, nor more than `limit` tuples.
  void reset(unsigned min_views, std::size_t limit);

  /// Extends a pair to the tuples of all other cameras that agree with it, and keeps them.
  void grow(const BlobPair& seed);

  /// For a blob that several hypotheses want: adds each of them without it.
  void split_contested();

  std::size_t size() const noexcept { return hypotheses_.size(); }
  const Hypothesis& operator[](std::size_t k) const noexcept { return hypotheses_[k]; }
  /// See Point::certain.
  bool certain(std::size_t hypothesis) const noexcept;
  std::span<const std::uint32_t> blobs_of(const Hypothesis& h) const noexcept {
    return {members_.data() + h.first, h.count};
  }
  /// The limit was reached: what was found later is not there, and is counted as cut.
  bool full() const noexcept { return full_; }
  std::uint64_t cut() const noexcept { return cut_; }
  std::uint64_t held_back() const noexcept { return held_back_; }

 private:
  struct Partial;  // a tuple on its way through the cameras
  struct Next {
    double spread;
    std::uint32_t camera;
  };

  bool already_together(std::uint32_t a, std::uint32_t b) const noexcept;
  void order_cameras(const Partial& seed);
  void extend_into(std::size_t camera, const Partial& partial);
  void consider(BlobTuple tuple);
  bool evaluate(BlobTuple& tuple, Hypothesis& h) const noexcept;
  bool fit(BlobTuple& tuple, std::array<Observation, kMatchCameras>& views,
           Triangulated& point) const noexcept;
  double score_of(const BlobTuple& tuple, std::span<const Observation> views, Hypothesis& h) const noexcept;
  bool shared_by_others(std::uint32_t blob, std::size_t hypothesis, double least_score) const noexcept;

  std::span<const Camera> cameras_;
  const MatchOptions& options_;
  const BlobTable& table_;
  TriangulateOptions triangulate_options_;
  double log_volume_ = 0.0, log_density_ = 0.0;  // of the space; of markers in it, per m^3
  std::vector<double> log_clutter_;              // per pixel^2, by camera
  unsigned min_views_ = 2;
  std::size_t limit_ = 0;
  bool full_ = false;

  std::vector<Hypothesis> hypotheses_;
  std::vector<std::uint32_t> members_;               // blobs
  std::vector<std::uint32_t> owner_, next_of_blob_;  // by member: its hypothesis, the blob's next member
  std::vector<std::uint32_t> head_of_blob_;
  SeenSet seen_;
  std::vector<Partial> beam_, grown_;
  std::vector<Next> order_;
  std::uint64_t cut_ = 0, held_back_ = 0;
};

struct Hypotheses::Partial {
  Eigen::Vector3d position;
  Eigen::Matrix3d covariance;
  double score = 0.0;
  BlobTuple tuple;
};

}  // namespace glint
