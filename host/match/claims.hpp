// SPDX-License-Identifier: MIT
// Which blobs each track claims: per track, the likeliest choices of one blob or none in every camera.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "host/geometry/triangulate.hpp"
#include "host/match/blob_table.hpp"
#include "host/match/blob_tuple.hpp"
#include "host/match/expected_views.hpp"
#include "host/match/prediction.hpp"

namespace glint {

/// One choice of blobs for one track.
struct Claim {
  std::uint32_t prediction = 0;
  BlobTuple tuple;
  Triangulated point;
  double score = 0.0;  ///< log-likelihood ratio against "no camera saw the marker, and the blobs are clutter"
};

/// What a claim must rest on.
enum class ClaimViews : std::uint8_t {
  Several,      ///< two cameras or more
  SharpSingle,  ///< one will do that shows a blob just where the prediction leaves no choice
  Single,       ///< one will do
};

/// Starts from the prediction, not from pairs of blobs, so that the cost is linear in tracks and cameras
/// while gates hold few blobs. Keeps its memory.
class Claims {
 public:
  /// All borrowed for the life of this.
  Claims(std::span<const Camera> cameras, const MatchOptions& options, const BlobTable& table,
         const ExpectedViews& expected);

  /// Replaces what was found before; `expected` has been filled with the same predictions. `settled` (by
  /// prediction, not 0): has its blobs already, and is left out. One view
  /// will do only where the prediction allows that.
  void find(std::span<const Prediction> predictions, std::span<const std::uint8_t> settled, ClaimViews views);

  std::span<const Claim> all() const noexcept { return claims_; }
  /// What the claim's views look like with the track's bias taken off.
  Observation observation(const Prediction& prediction, std::uint32_t blob) const noexcept;

 private:
  /// Where one camera expects one track.
  struct Sight {
    std::uint32_t camera = 0;
    const ExpectedView* expected = nullptr;
    double log_clutter = 0.0;            ///< per pixel^2, around the place: blobs of other markers, mostly
    std::uint32_t first = 0, count = 0;  ///< candidates
    bool contested = false;
  };
  struct Partial {  // relative to the prediction's mean
    Eigen::Vector3d move;
    Eigen::Matrix3d covariance;
    double score;
    BlobTuple tuple;
  };

  bool collect(std::uint32_t number, const Prediction& prediction);
  void count_wishes();
  void search(std::uint32_t number, const Prediction& prediction, std::span<Sight> sights);
  enum class Skip : std::uint8_t { IfDoubtful, Always };  // try without a camera's blob, too
  bool grow_beam(const Prediction& prediction, std::span<const Sight> sights, Skip skip);
  bool extend(const Sight& sight, const Partial& partial, Skip skip);
  bool evaluate(const Prediction& prediction, std::span<const Sight> sights, Claim& claim) const noexcept;
  bool complete(const Prediction& prediction, std::span<const Sight> sights, Claim& claim) const noexcept;
  double score_of(const Prediction& prediction, std::span<const Sight> sights, const Claim& claim,
                  std::span<const Observation> views) const noexcept;
  bool better_alone(const Prediction& prediction, std::span<const Sight> sights,
                    const Claim& claim) const noexcept;

  std::span<const Camera> cameras_;
  const MatchOptions& options_;
  const BlobTable& table_;
  const ExpectedViews& expected_;
  std::uint32_t least_views_ = 2;
  bool sharp_only_ = false;
  std::vector<double> log_clutter_;
  std::vector<Sight> sights_;
  std::vector<std::uint32_t> candidates_;
  std::vector<std::uint32_t> first_sight_;  // by prediction, and one more
  std::vector<std::uint32_t> wishes_;       // by blob: how many tracks may claim it
  std::vector<Partial> beam_, grown_;
  std::vector<Claim> claims_;
};

}  // namespace glint
