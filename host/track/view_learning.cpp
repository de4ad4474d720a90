// SPDX-License-Identifier: MIT
// Biases of views and brightness of markers.
#include "host/track/view_learning.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace glint {
namespace {

// How far a marker travels until the calibration's error there has little to do with that where it was: lens
// models err over a good part of the image, poses over the whole room.
constexpr double kBiasLength_m = 2.0;
constexpr double kUnknownShare =
    0.05;  // of the calibration's variance: a bias worse known than this is asked for
constexpr double kNeighbour_m = 0.3;
// By so much is what is thought of a marker's brightness moved each time.
constexpr double kBrightnessStep = 1.03, kDullest = 0.1, kBrightest = 2.0;

}  // namespace

void forget_bias(Track& track, double seconds, std::span<const double> calibration_px2) noexcept {
  const double kept = std::exp(-track.motion.velocity().norm() * seconds / kBiasLength_m);
  for (std::size_t camera = 0; camera < calibration_px2.size(); ++camera) {
    ViewBias& bias = track.bias[camera];
    bias.px *= kept;
    bias.variance_px2 = kept * kept * bias.variance_px2 + (1.0 - kept * kept) * calibration_px2[camera];
  }
}

// A scalar Kalman step per camera; the position's own uncertainty, about the blobs', counts as noise.
void learn_bias(Track& track, const Point& point, std::span<const double> calibration_px2) noexcept {
  for (std::size_t camera = 0; camera < calibration_px2.size(); ++camera) {
    if (point.blob_of_camera[camera] < 0) continue;
    ViewBias& bias = track.bias[camera];
    const double gain =
        bias.variance_px2 / (bias.variance_px2 + 2.0 * static_cast<double>(point.noise_px2[camera]));
    if (!(gain > 0.0)) continue;
    bias.px += gain * (point.residual_px[camera].cast<double>() - bias.px);
    bias.variance_px2 *= 1.0 - gain;
  }
}

void ask_neighbours(Track& track, std::span<const Track> tracks,
                    std::span<const double> calibration_px2) noexcept {
  const auto knows_little = [&](std::size_t camera) {
    return track.bias[camera].variance_px2 > kUnknownShare * calibration_px2[camera];
  };
  bool asks = false;
  for (std::size_t camera = 0; camera < calibration_px2.size(); ++camera) asks = asks || knows_little(camera);
  if (!asks) return;
  for (const Track& other : tracks) {
    if (&other == &track || other.age > 0 || other.seen < kSettledFrames) continue;
    const double away2_m2 = (other.motion.position() - track.motion.position()).squaredNorm();
    if (away2_m2 > kNeighbour_m * kNeighbour_m) continue;
    const double kept = std::exp(-std::sqrt(away2_m2) / kBiasLength_m);
    for (std::size_t camera = 0; camera < calibration_px2.size(); ++camera) {
      const ViewBias& theirs = other.bias[camera];
      ViewBias& own = track.bias[camera];
      const double variance_px2 =
          kept * kept * theirs.variance_px2 + (1.0 - kept * kept) * calibration_px2[camera];
      if (knows_little(camera) && variance_px2 < own.variance_px2) own = {kept * theirs.px, variance_px2};
    }
  }
}

void learn_brightness(Track& track, const Point& point) noexcept {
  const auto light = static_cast<double>(point.light);
  if (!(light > 0.0) || point.views < 2) return;
  const double step = light > track.brightness ? kBrightnessStep : 1.0 / kBrightnessStep;
  track.brightness = std::clamp(track.brightness * step, kDullest, kBrightest);
}

}  // namespace glint
