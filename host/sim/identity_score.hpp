// SPDX-License-Identifier: MIT
// Does a tracker know which marker is which, and when it does not? Every figure of the identity benchmark.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/sim/id_history.hpp"
#include "host/sim/log_histogram.hpp"
#include "host/sim/mixed_points.hpp"
#include "host/sim/nees_band.hpp"
#include "host/sim/point_assignment.hpp"
#include "host/sim/scene.hpp"

namespace glint {

/// One point of a tracker's output.
struct IdentitySample {
  std::uint32_t id = 0;  ///< of its track; 0: none
  Eigen::Vector3d position_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();  ///< of the position; all 0: unknown
  std::uint32_t cameras = 0;                                ///< bit set of cameras used; 0: unknown
  bool predicted = false;  ///< the tracker says that this is no measurement by two or more cameras
  bool ambiguous = false;  ///< the tracker says that it may be another marker
};

struct IdentityOptions {
  double gate_m = 0.01;        ///< a sample farther than this from every marker is a ghost. Must be smaller
                               ///< than two markers can come to each other (a diameter, 12.6 mm)
  double image_gate_px = 3.0;  ///< of mixed points, beyond the radius of the marker's image
  std::uint64_t away_ticks = 10;  ///< a camera that lacked so many frames in a row and gives one is back
  double block_s = 1.0;           ///< of the bootstrap
  std::uint32_t bootstrap_rounds = 1000;
  std::uint64_t bootstrap_seed = 1;
};

/// No tick and no sample is left out. "Measured" are all samples that are not marked predicted; only these
/// are assigned to markers, by position alone (sim::PointAssignment). Ratios are 0 where nothing was counted.
struct IdentityResult {
  std::uint64_t ticks = 0;
  std::uint64_t measured = 0;  ///< samples
  std::uint64_t expected = 0;  ///< markers visible in two or more delivered frames, merged or not, per tick
  std::uint64_t found = 0;     ///< of these: with a measured sample
  std::uint64_t ghosts = 0;    ///< measured samples with no marker within the gate
  std::uint64_t doubled = 0;   ///< measured samples whose markers within the gate all have another one
  std::uint64_t mixed = 0;     ///< sim::MixedPoints, of measured samples that name their cameras
  std::uint64_t mixed_checked = 0;  ///< those that name them
  /// An id is read where its measured sample is assigned to the only marker within the gate; then it is on
  /// that marker beyond doubt. sim::IdHistory::Counts says what is counted. A swap is silent unless some
  /// sample of that id was marked ambiguous, from the last one on the old marker to the first on the new one,
  /// inclusive.
  sim::IdHistory::Counts ids;
  std::uint64_t longest_gap_frames = 0;  ///< most frames in a row in which one marker is expected and not
                                         ///< found; frames in which it is not expected are passed over
  double recall = 0.0;                   ///< found / expected
  double ghosts_per_tick = 0.0, doubled_per_tick = 0.0;
  double rms_m = 0.0, worst_m = 0.0;    ///< 3D error of all measured samples that have a marker
  double median_m = 0.0, q999_m = 0.0;  ///< to 1 %
  double ambiguous_share = 0.0;         ///< of all samples
  /// Samples marked predicted are compared with the marker that their id was on last, however far.
  double predicted_share = 0.0;  ///< of all samples
  double predicted_rms_m = 0.0, predicted_worst_m = 0.0;
  std::uint64_t predicted = 0, predicted_of_nothing = 0;  ///< the latter: their id was on no marker yet
  /// e' C^-1 e / 3 of measured samples that have a marker and a covariance: mean and its 95 % band. Honest
  /// covariances have 1 in the band.
  sim::NeesBand::Result nees;
  std::uint64_t covariance_faults = 0;  ///< covariances that are not finite or not positive definite
  /// Cameras that came back, and the most frames that passed, after the first with the camera back, until all
  /// expected markers were found in one frame (the run's end ends the count).
  std::uint64_t cameras_back = 0, recovery_frames = 0;
  /// Scenes of a rod with two markers: error of their distance where both have a measured sample.
  std::uint64_t pairs = 0;
  double pair_rms_m = 0.0, pair_worst_m = 0.0;

  /// How far 1 lies outside the band: 0 within it or without samples, infinite with faulty covariances.
  double nees_outside() const noexcept;
};

/// Thread-bound. No allocation in add() once warm, up to 4096 ids and two minutes.
class IdentityScore {
 public:
  /// `scene` must outlive the score.
  explicit IdentityScore(const Scene& scene, const IdentityOptions& options = {});
  /// Wanted for every tick of the run, in order, also without samples.
  void add(std::uint64_t tick, std::span<const IdentitySample> samples);
  IdentityResult result() const;

 private:
  void count_expected();
  void count_measured(const IdentitySample& sample, std::size_t place);
  void count_predicted(const IdentitySample& sample);
  void count_normalised_error(const IdentitySample& sample, std::uint32_t marker,
                              const Eigen::Vector3d& error);
  void count_recovery(bool complete);
  void count_pair();

  const Scene& scene_;
  IdentityOptions options_;
  bool rod_;  // two markers on a wand
  TickTruth truth_;
  std::vector<Eigen::Vector3d> markers_, measured_;  // positions
  std::vector<const IdentitySample*> sample_of_measured_;
  sim::PointAssignment assignment_;
  sim::MixedPoints mixed_points_;
  sim::IdHistory history_;
  sim::NeesBand nees_;
  sim::LogHistogram errors_;
  std::vector<std::uint64_t> gap_frames_;               // per marker, at present
  std::array<std::uint64_t, gpu::kMaxCameras> away_{};  // frames in a row that the camera lacks
  bool recovering_ = false;
  std::uint64_t recovering_frames_ = 0;
  IdentityResult counts_;
  std::uint64_t matched_ = 0, ambiguous_ = 0;
  double sum_error2_ = 0.0, sum_predicted_error2_ = 0.0, sum_pair_error2_ = 0.0;
};

}  // namespace glint
