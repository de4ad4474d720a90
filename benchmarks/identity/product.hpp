// SPDX-License-Identifier: MIT
// glint itself on a scene: rendered frames, detector, matcher and tracker as `glint track sim` runs them.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "host/pipeline/tick_input.hpp"
#include "host/pipeline/track_pipeline.hpp"
#include "host/pipeline/track_step.hpp"
#include "host/sim/identity_score.hpp"
#include "host/sim/pose_score.hpp"
#include "host/sim/scene.hpp"

namespace glint::identity {

/// What trackers are told of where the cameras stand.
Calibration given_calibration(const Scene& scene, double calibration_error_px);

/// Rendered and detected on the CPU, as fast as that goes, the background learnt from the first frames.
/// `scene` must outlive it. Throws Error, gpu::Error.
std::unique_ptr<TickInput> open_scene(const Scene& scene, std::uint64_t ticks);

/// An input that shows what passes through to somebody else as well, on the thread that calls next().
class TappedInput final : public TickInput {
 public:
  using Tap = std::function<void(const TickBlobs& tick)>;
  TappedInput(std::unique_ptr<TickInput> input, Tap tap) : input_(std::move(input)), tap_(std::move(tap)) {}

  std::span<const SourceCamera> cameras() const noexcept override { return input_->cameras(); }
  bool live() const noexcept override { return input_->live(); }
  double rate_hz() const noexcept override { return input_->rate_hz(); }
  const std::string& device_name() const noexcept override { return input_->device_name(); }
  [[nodiscard]] ReadStatus next(TickBlobs& tick) noexcept override;
  void stop() noexcept override { input_->stop(); }
  InputCounters counters() const noexcept override { return input_->counters(); }
  std::string problem() const override { return input_->problem(); }

 private:
  std::unique_ptr<TickInput> input_;
  Tap tap_;
};

/// glint's output as the score takes it. A sample that no two cameras measured counts as predicted.
void to_samples(std::span<const TrackedPoint> points, std::vector<IdentitySample>& samples);

/// glint that knows the scene's bodies, scored on markers and on poses.
class BodiesKnown {
 public:
  /// `scene` must outlive it. Throws Error.
  BodiesKnown(const Scene& scene, const Calibration& calibration);
  /// Every tick, in order.
  void take(const TickBlobs& tick);
  IdentityResult markers() const { return of_markers_.result(); }
  PoseResult poses() const { return of_poses_.result(); }

 private:
  TrackStep step_;
  IdentityScore of_markers_;
  PoseScore of_poses_;
  std::vector<IdentitySample> samples_;
  std::vector<ScoredPose> scored_;
};

/// Tracks to the end of the input; `take` is called for every tick. Throws Error.
void track(std::unique_ptr<TickInput> input, const Calibration& calibration, double marker_radius_m,
           const std::function<void(std::uint64_t tick, std::span<const IdentitySample>)>& take);

}  // namespace glint::identity
