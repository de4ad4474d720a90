// SPDX-License-Identifier: MIT
#include "host/pipeline/track_step.hpp"

namespace glint {
namespace {

constexpr std::size_t kPointsReserved = 512;

}  // namespace

TrackStep::TrackStep(const Calibration& calibration, const MatchOptions& match, const TrackOptions& track,
                     std::span<const BodyModel> bodies)
    : matcher_(calibration, match),
      tracker_(track, calibration_sd_px(calibration)),
      health_(calibration, match) {
  if (!bodies.empty()) bodies_.emplace(calibration, match, bodies);
  predictions_.reserve(kPointsReserved);
  points_.reserve(kPointsReserved);
  tracked_.reserve(kPointsReserved);
  watched_.reserve(kPointsReserved);
}

void TrackStep::take(const TickBlobs& tick) noexcept {
  tracker_.predict(tick.exposed, predictions_);
  if (bodies_) bodies_->predict(tick.exposed, predictions_);
  dark_ = tick.dark;
  if (dark_) {
    points_.clear();
    tracked_.clear();
  } else {
    matcher_.match(
        tick.cameras, predictions_, points_, match_counters_,
        tick.has_images ? std::span<const gpu::ImageView>(tick.images) : std::span<const gpu::ImageView>());
    tracker_.update(points_, tracked_, track_counters_);
    if (bodies_) bodies_->update(points_, tracked_);
  }
}

void TrackStep::watch(const TickBlobs& tick) noexcept {
  if (tick.dark) return;
  watched_.clear();
  for (const TrackedPoint& point : tracked_)
    if (point.kind == SampleKind::Measured) watched_.push_back({point.point, point.velocity_in_world});
  health_.watch({tick.exposed, tick.frames, tick.cameras, points_, watched_});
}

}  // namespace glint
