// SPDX-License-Identifier: MIT
// How one marker moves: several models side by side, weighted by how well each foretold what was measured.
#pragma once

#include <array>

#include <Eigen/Core>

#include "host/match/prediction.hpp"

namespace glint {

/// What a set of views says of a position, without any expectation: see Point.
struct PositionEvidence {
  Eigen::Vector3d near_in_world = Eigen::Vector3d::Zero();
  Eigen::Matrix3d information_per_m2 = Eigen::Matrix3d::Zero();
  Eigen::Vector3d gradient_per_m = Eigen::Vector3d::Zero();
};

/// Interacting multiple models (Blom and Bar-Shalom, IEEE Trans. Automatic Control 33, 1988): a marker under
/// an acceleration that changes not at all (in flight, at rest), hardly, somewhat or much, and one that is
/// pulled about. The last has no acceleration in its state: when the five are mixed it says nothing of it
/// (Yuan, Han, Bar-Shalom, 2012, "unbiased mixing"). Units m, s.
class Motion {
 public:
  /// A marker first seen: its velocity is zero within velocity_sd_m_s per axis, its acceleration within the
  /// usual one.
  Motion(const Eigen::Vector3d& position, const Eigen::Matrix3d& covariance_m2, double velocity_sd_m_s,
         double acceleration_sd_m_s2) noexcept;

  /// By the true time between exposures. acceleration_sd_m_s2: what is usual for the markers.
  void advance(double seconds, double acceleration_sd_m_s2) noexcept;
  /// All models learn from the same views, and each is believed as much as it expected them. One view is
  /// enough. Where none expected them, the marker hit something: then its velocity is learnt anew. Returns
  /// the log of how likely the views were, but for a term that depends on the views alone.
  double correct(const PositionEvidence& evidence) noexcept;

  /// What correct() would return.
  double log_likelihood(const PositionEvidence& evidence) const noexcept {
    return Motion(*this).correct(evidence);
  }

  /// How far a marker that hits something can be from where it was last seen: as far as its speed takes it. 0
  /// where that was too long ago to be of use.
  double impact_reach_m() const noexcept;
  /// Log of the density of a measured position, over all models and an impact.
  double log_density(const Eigen::Vector3d& measured, const Eigen::Matrix3d& covariance_m2) const noexcept;
  /// Squared Mahalanobis distance of a measured position from the model that is nearest, three degrees of
  /// freedom.
  double distance2(const Eigen::Vector3d& measured, const Eigen::Matrix3d& covariance_m2) const noexcept;

  /// How often it was found to have hit something.
  unsigned impacts() const noexcept { return impacts_; }
  const Eigen::Vector3d& position() const noexcept { return position_; }
  const Eigen::Vector3d& velocity() const noexcept { return velocity_; }
  const Eigen::Matrix3d& position_covariance() const noexcept { return position_covariance_; }
  std::array<PredictedMode, kMotionModes> modes() const noexcept;

 private:
  struct Mode {
    double weight = 0.0;
    Eigen::Vector3d p, v, a;
    Eigen::Matrix3d pp, pv, pa, vv, va, aa;  // pv is the covariance of p (rows) and v (columns)
  };
  void mix(double seconds) noexcept;
  Eigen::Matrix3d impact_covariance() const noexcept;
  void summarise() noexcept;

  std::array<Mode, kMotionModes> modes_;
  Eigen::Vector3d position_, velocity_;
  Eigen::Matrix3d position_covariance_;
  double speed_m_s_ = 0.0;  ///< largest of late
  double unseen_s_ = 0.0;   ///< since the last correction
  unsigned unseen_steps_ = 0;
  unsigned impacts_ = 0;
};

}  // namespace glint
