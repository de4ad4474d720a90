// SPDX-License-Identifier: MIT
// Sizes of blobs against each other.
#include "host/match/odd_sizes.hpp"

#include <algorithm>
#include <cmath>

namespace glint {
namespace {

// Size of a blob against what the other views (or the known radius) give: thresholds and blur move small
// blobs by about half a pixel, so that only these factors and at least so many pixels mean something else
// than one whole marker.
constexpr double kSizeTooLarge = 1.5, kSizeTooSmall = 0.67, kSizeMargin_px = 0.75;
// Blur and the threshold's place on its flank: how much wider than its geometric image a marker may look.
constexpr double kBlurAllowance_px = 1.5;

}  // namespace

std::uint32_t widen_odd_sizes(std::span<const Camera> cameras, const MatchOptions& options,
                              const BlobTable& table, const BlobTuple& tuple,
                              const Eigen::Vector3d& position_in_world,
                              std::array<Observation, kMatchCameras>& views) noexcept {
  std::array<double, kMatchCameras> sizes{}, px_per_m{};
  std::size_t known = 0;
  for (std::size_t k = 0; k < tuple.count; ++k) {
    const MatchBlob& blob = table[tuple.blobs[k]];
    const double range = (position_in_world - cameras[blob.camera].position_in_world()).norm();
    px_per_m[k] = 1.0 / (range * blob.angle_per_px);
    if (blob.radius_px > 0.0) sizes[known++] = blob.radius_px / px_per_m[k];
  }
  if (known < (options.marker_radius_m > 0.0 ? 1 : 3)) return 0;
  double typical = 0.0;
  if (known >= 3) {
    std::nth_element(sizes.begin(), sizes.begin() + (known - 1) / 2, sizes.begin() + known);
    typical = sizes[(known - 1) / 2];
  }
  std::uint32_t widened = 0;
  for (std::size_t k = 0; k < tuple.count; ++k) {
    const MatchBlob& blob = table[tuple.blobs[k]];
    if (blob.radius_px <= 0.0 || blob.saturated) continue;
    double difference = 0.0;
    if (typical > 0.0) {
      const double expected = typical * px_per_m[k], d = blob.radius_px - expected;
      if ((blob.radius_px > kSizeTooLarge * expected || blob.radius_px < kSizeTooSmall * expected) &&
          std::abs(d) > kSizeMargin_px)
        difference = d;
    } else {
      const double expected = options.marker_radius_m * px_per_m[k];
      if (const double d = blob.radius_px - kSizeTooLarge * expected - kBlurAllowance_px; d > 0.0)
        difference = d;
      if (const double d = kSizeTooSmall * expected - kSizeMargin_px - blob.radius_px; d > 0.0)
        difference = -d;
    }
    if (difference == 0.0) continue;
    views[k].covariance_px2 += difference * difference * Eigen::Matrix2d::Identity();
    widened |= 1u << blob.camera;
  }
  return widened;
}

}  // namespace glint
