// SPDX-License-Identifier: MIT
#include "host/target/wand_finder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace glint {
namespace {

constexpr std::size_t kMostBlobs = 24;  // of one image: triples grow with the cube
constexpr double kOffLine_px =
    2.0;  // centroids, and a wand that is not quite straight: 1 mm at 1 m is 0.9 px
constexpr double kShortest_px = 12.0;  // between the ends: seen end on, the spacings tell nothing
constexpr double kNearest_m = 0.25;  // of a wand to a lens: nearer, readings the wrong way round begin to fit
constexpr double kFarthest_m = 30.0;
// Of the depth ratios of both readings of the ends, whose logarithms have a fixed sum: at 0.5 they are equal.
constexpr double kSteepest = 0.3;
constexpr double kClearly = 1.5;  // by which the second best reading must be worse

}  // namespace

WandFinder::WandFinder(const Target& target, const CameraCalibration& camera)
    : target_(target), camera_(camera) {}

std::vector<FoundMarker> WandFinder::find(std::span<const shaders::BlobRecord> blobs) {
  ++counters_.images;
  std::vector<Candidate> candidates;
  for (const shaders::BlobRecord& blob : blobs) {
    if ((blob.flags & shaders::kBlobOnBorder) != 0) continue;
    const Eigen::Vector2d pixel(static_cast<double>(blob.x_px), static_cast<double>(blob.y_px));
    const auto plane = camera_.undistort(pixel);
    if (plane) candidates.push_back({pixel, *plane});
  }
  const std::size_t wanted = target_.points_in_target.size();
  std::vector<FoundMarker> found;
  if (candidates.size() < wanted) {
    ++counters_.too_few;
  } else if (wanted == 3 && candidates.size() <= kMostBlobs) {
    found = find_three(candidates);
  } else if (candidates.size() == wanted) {
    for (std::uint32_t i = 0; i < wanted; ++i) found.push_back({i, candidates[i].pixel});
  } else {
    ++counters_.no_match;
  }
  if (!found.empty()) ++counters_.found;
  return found;
}

// Let the rays to the markers be u1, u2, u3 with third coordinate 1 and the depths z1, z2, z3. The middle
// marker at the share r of the wand's length gives z2 u2 = (1-r) z1 u1 + r z3 u3, hence, if it appears at the
// share s from u1 to u3, z3/z1 = s (1-r) / (r (1-s)). The length then gives z1. Read the other way round, the
// same image has the ratio ((1-r)/r)^2 / (z3/z1): the steeper of the two readings is taken for wrong, and
// both are where they do not clearly differ.
double WandFinder::misfit(const Candidate& first, const Candidate& middle, const Candidate& last) const {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const CameraCalibration& c = camera_.calibration();
  const Eigen::Vector2d focal(c.fx_px, c.fy_px);
  const Eigen::Vector2d along = (last.plane - first.plane).cwiseProduct(focal);
  const Eigen::Vector2d to_middle = (middle.plane - first.plane).cwiseProduct(focal);
  const double length_px = along.norm();
  if (length_px < kShortest_px) return kNever;
  const double s = to_middle.dot(along) / (length_px * length_px);
  if (!(s > 0.02) || !(s < 0.98)) return kNever;
  const double off_px = std::abs(along.x() * to_middle.y() - along.y() * to_middle.x()) / length_px;
  if (off_px > kOffLine_px + 0.01 * length_px) return kNever;
  const double length_m = target_.points_in_target[2].x(), r = target_.points_in_target[1].x() / length_m;
  const double depth_ratio = s * (1.0 - r) / (r * (1.0 - s)), steepness = std::abs(std::log(depth_ratio));
  const double of_both = 2.0 * std::abs(std::log((1.0 - r) / r));
  if (steepness > kSteepest * of_both) return kNever;
  const Eigen::Vector3d between = depth_ratio * last.plane.homogeneous() - first.plane.homogeneous();
  const double depth_m = length_m / between.norm();
  if (std::min(depth_m, depth_m * depth_ratio) < kNearest_m ||
      std::max(depth_m, depth_m * depth_ratio) > kFarthest_m)
    return kNever;
  return off_px + length_px * steepness * 0.1;
}

std::vector<FoundMarker> WandFinder::find_three(const std::vector<Candidate>& candidates) {
  double best = std::numeric_limits<double>::infinity(), second = best;
  std::vector<FoundMarker> found;
  const std::size_t count = candidates.size();
  for (std::size_t i = 0; i < count; ++i) {
    for (std::size_t k = 0; k < count; ++k) {
      if (k == i) continue;
      for (std::size_t j = 0; j < count; ++j) {
        if (j == i || j == k) continue;
        const double misfit = this->misfit(candidates[i], candidates[j], candidates[k]);
        if (misfit >= second) continue;
        second = std::max(best, misfit);
        if (misfit >= best) continue;
        best = misfit;
        found = {{0, candidates[i].pixel}, {1, candidates[j].pixel}, {2, candidates[k].pixel}};
      }
    }
  }
  if (found.empty()) {
    ++counters_.no_match;
  } else if (second < kClearly * std::max(best, 1.0)) {
    ++counters_.ambiguous;
    found.clear();
  }
  return found;
}

}  // namespace glint
