// SPDX-License-Identifier: MIT
// Tallies of one camera's blobs in another camera's calibration.
#include "host/health/swap_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/Geometry>

#include "host/geometry/triangulate.hpp"
#include "host/match/visible_volume.hpp"

namespace glint::health {
namespace {

constexpr double kFade_s = 0.5;
constexpr double kFar_m = 1e6;
// Raw pixels around a predicted place: room for calibrations that are a pixel off.
constexpr double kNear_px = 3.0;
// Images with more blobs than this per square pixel have one anywhere.
constexpr double kMostByChance = 0.1;
// Markers are hidden and merge, but a right guess finds most of them; chance finds a tenth at most.
constexpr double kLeastTested = 10.0, kLeastShare = 0.5;
constexpr std::size_t kMostRays = 32;  // of one camera in one exposure

bool few_enough(std::span<const shaders::BlobRecord> blobs, const Camera& camera) noexcept {
  const CameraCalibration& c = camera.calibration();
  const double by_chance = std::numbers::pi * kNear_px * kNear_px * static_cast<double>(blobs.size()) /
                           std::max(1.0, static_cast<double>(c.width_px) * c.height_px);
  return by_chance <= kMostByChance;
}

/// Raw pixel of a point that lies in the image.
std::optional<Eigen::Vector2d> image_of(const Eigen::Vector3d& point_in_world,
                                        const Camera& camera) noexcept {
  if (!sees(camera, point_in_world, 0.0, 0.0, kFar_m)) return std::nullopt;
  return camera.project(point_in_world);
}

bool any_near(const Eigen::Vector2d& pixel, std::span<const shaders::BlobRecord> blobs) noexcept {
  return std::any_of(blobs.begin(), blobs.end(), [&](const shaders::BlobRecord& blob) {
    return std::hypot(static_cast<double>(blob.x_px) - pixel.x(),
                      static_cast<double>(blob.y_px) - pixel.y()) < kNear_px;
  });
}

}  // namespace

SwapSearch::Tally& SwapSearch::fade(std::size_t images, std::size_t lens, double time_s) noexcept {
  Tally& tally = tallies_[images * cameras_ + lens];
  const double keep = std::exp(-std::max(0.0, time_s - tally.time_s) / kFade_s);
  tally.time_s = time_s;
  tally.tested *= keep;
  tally.found *= keep;
  return tally;
}

void SwapSearch::add(std::size_t images, std::size_t lens, double time_s, std::span<const OthersPoint> points,
                     std::span<const shaders::BlobRecord> blobs, const ComparedCamera& through) noexcept {
  if (!few_enough(blobs, through.camera())) return;
  Tally& tally = fade(images, lens, time_s);
  for (const OthersPoint& point : points) {
    const auto pixel = image_of(point.position_in_world, through.camera());
    if (!pixel) continue;
    tally.tested += 1.0;
    if (any_near(*pixel, blobs)) tally.found += 1.0;
  }
}

void SwapSearch::add_triples(std::size_t a, std::size_t b, std::size_t witness, double time_s,
                             std::span<const std::span<const shaders::BlobRecord>> blobs,
                             std::span<const ComparedCamera> cameras) noexcept {
  const Camera &from_witness = cameras[witness].camera(), &place_of_a = cameras[a].camera(),
               &place_of_b = cameras[b].camera();
  if (!few_enough(blobs[a], place_of_b) || !few_enough(blobs[b], place_of_a)) return;
  struct Ray {
    Eigen::Vector2d normalized;
    Eigen::Vector3d direction;
  };
  std::array<Ray, kMostRays> rays;
  std::size_t count = 0;
  for (const shaders::BlobRecord& blob : blobs[a]) {
    if (count == rays.size()) break;
    const auto normalized =
        place_of_b.undistort({static_cast<double>(blob.x_px), static_cast<double>(blob.y_px)});
    if (normalized) rays[count++] = {*normalized, place_of_b.direction_in_world(*normalized)};
  }
  const Eigen::Vector3d baseline = place_of_b.position_in_world() - from_witness.position_in_world();
  const double most_sine = kNear_px / cameras[b].focal_px();
  std::size_t tested = 0, found = 0;
  for (const shaders::BlobRecord& blob : blobs[witness]) {
    if (tested == kMostRays) break;
    const Eigen::Vector2d seen(static_cast<double>(blob.x_undist), static_cast<double>(blob.y_undist));
    const Eigen::Vector3d across = baseline.cross(from_witness.direction_in_world(seen)).normalized();
    ++tested;
    for (std::size_t k = 0; k < count; ++k) {
      if (std::abs(across.dot(rays[k].direction)) > most_sine) continue;
      const std::array<Observation, 2> pair{Observation{&from_witness, seen},
                                            Observation{&place_of_b, rays[k].normalized}};
      const auto point = triangulate(pair, {});
      const auto pixel = point ? image_of(point->position_in_world, place_of_a) : std::nullopt;
      if (!pixel || !any_near(*pixel, blobs[b])) continue;
      ++found;
      break;
    }
  }
  for (Tally* const tally : {&fade(a, b, time_s), &fade(b, a, time_s)}) {
    tally->tested += static_cast<double>(tested);
    tally->found += static_cast<double>(found);
  }
}

bool SwapSearch::fits(const Tally& tally, double time_s) const noexcept {
  return time_s - tally.time_s < kFade_s && tally.tested >= kLeastTested &&
         tally.found >= kLeastShare * tally.tested;
}

bool SwapSearch::swapped(std::size_t a, std::size_t b, double time_s) const noexcept {
  return fits(tally(a, b), time_s) && fits(tally(b, a), time_s);
}

void SwapSearch::clear() noexcept { std::fill(tallies_.begin(), tallies_.end(), Tally{}); }

}  // namespace glint::health
