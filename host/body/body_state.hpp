// SPDX-License-Identifier: MIT
// What the tracker knows of one body, and its fit to the samples of one exposure.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "host/body/body_motion.hpp"
#include "host/body/body_pose_fit.hpp"
#include "host/body/body_shapes.hpp"
#include "host/body/body_tracker.hpp"

namespace glint {

inline constexpr std::uint32_t kNoSample = 0xffffffffu;
inline constexpr double kPoseChi2 = 27.9;    ///< six degrees of freedom, once in 10,000
inline constexpr double kSampleChi2 = 21.1;  ///< three degrees of freedom, once in 10,000

/// By then the motion's uncertainty is as large as a room.
inline constexpr double kMotionMemory_s = 1.0;

/// Samples of one exposure, found by track and by place.
class SampleIndex {
 public:
  void fill(std::span<const MarkerSample> samples);
  std::span<const MarkerSample> samples() const noexcept { return samples_; }
  std::uint32_t of_track(TrackId track) const noexcept;
  bool used(std::uint32_t sample) const noexcept { return used_[sample] != 0; }
  void use(std::uint32_t sample, bool use) noexcept { used_[sample] = use ? 1 : 0; }
  /// Calls visit(sample) for each unused one within reach.
  template <typename Visit>
  void near(const Eigen::Vector3d& at, double reach_m, Visit&& visit) const {
    for (auto k = first_beyond(at.x() - reach_m); k < by_x_.size(); ++k) {
      const Eigen::Vector3d d = samples_[by_x_[k]].position_in_world - at;
      if (d.x() > reach_m) break;
      if (used_[by_x_[k]] == 0 && d.squaredNorm() <= reach_m * reach_m) visit(by_x_[k]);
    }
  }

 private:
  std::size_t first_beyond(double x) const noexcept;

  std::span<const MarkerSample> samples_;
  std::vector<std::uint32_t> by_track_, by_x_;
  std::vector<std::uint8_t> used_;
};

enum class BodyLife : std::uint8_t { Lost, Tentative, Tracked };

/// One body. All poses are of its shape.
struct BodyState {
  BodyLife life = BodyLife::Lost;
  bool known = false;  ///< it has been shown before
  BodyMotion motion;   ///< after predict(): predicted; after update(): with what was measured
  std::array<TrackId, kBodyMarkers> track{};
  unsigned missed = 0, seen = 0, age = 0;  ///< frames
  Eigen::Vector3d last_place = Eigen::Vector3d::Zero();
  double since_measured_s = 0.0;

  // Of this exposure.
  std::array<std::uint32_t, kBodyMarkers> sample{};
  BodyFit fit;
  bool fitted = false, jumped = false;  ///< jumped: fitted without the prediction, which was far off
  unsigned markers = 0;

  /// It is lost only lately, so that its motion still says where it may be.
  bool moves_on() const noexcept {
    return life != BodyLife::Lost || (known && since_measured_s < kMotionMemory_s);
  }
  const Pose& pose() const noexcept { return fitted ? fit.world_from_body : motion.pose(); }
  Matrix6 covariance() const noexcept { return fitted ? fit.covariance : motion.pose_covariance(); }
};

/// Fits bodies to their samples. Keeps its memory.
class BodyFitter {
 public:
  explicit BodyFitter(double marker_radius_m) : marker_radius_m_(marker_radius_m) {}

  /// Takes the samples of the tracks that the body has.
  void claim(const ShapedBody& shaped, BodyState& body, SampleIndex& index) const noexcept;
  /// Fits the pose to the body's samples, with its prediction as prior, and lets go of what does not fit.
  void fit(const ShapedBody& shaped, BodyState& body, SampleIndex& index, BodyCounters& counters);
  /// Without a prior, from `start`.
  bool fit_alone(const ShapedBody& shaped, BodyState& body, const SampleIndex& index, const Pose& start);

 private:
  void collect(const ShapedBody& shaped, BodyState& body, const SampleIndex& index);
  bool try_fit(const ShapedBody& shaped, BodyState& body, const Pose& start, const PosePrior* prior);
  std::uint32_t worst_marker(const ShapedBody& shaped, const BodyState& body, const SampleIndex& index) const;
  bool fit_jump(const ShapedBody& shaped, BodyState& body, const SampleIndex& index);

  double marker_radius_m_;
  std::vector<BodyView> views_;
  std::vector<std::uint8_t> outlier_;
};

}  // namespace glint
