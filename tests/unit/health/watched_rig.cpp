// SPDX-License-Identifier: MIT
// Truth to blobs.
#include "tests/unit/health/watched_rig.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>

namespace glint::testing {
namespace {

double thread_cpu_s() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

struct Disc {
  Eigen::Vector2d middle;
  double radius_px, area_px2;
};

}  // namespace

WatchedRig::WatchedRig(const WatchedRigOptions& options)
    : options_(options),
      scene_(options.sim),
      matcher_(options.calibration ? *options.calibration : scene_.calibration(), options.match),
      tracker_(TrackOptions{}),
      health_(options.calibration ? *options.calibration : scene_.calibration(), options.match),
      random_(options.sim.seed * 7919 + 17),
      clutter_(options.sim.cameras),
      blobs_(options.sim.cameras) {
  const Calibration& told = options.calibration ? *options.calibration : scene_.calibration();
  for (const CameraCalibration& camera : told.cameras) cameras_.emplace_back(camera);
  for (auto& spots : clutter_)
    for (std::uint32_t n = 0; n < options.clutter; ++n)
      spots.emplace_back(random_.uniform(0.0, options.sim.width_px - 1.0),
                         random_.uniform(0.0, options.sim.height_px - 1.0));
}

void WatchedRig::make_blobs() {
  scene_.truth(tick_, truth_);
  std::array<sim::OutlinePoint, 32> outline;
  std::vector<Disc> discs;
  for (std::uint32_t c = 0; c < scene_.cameras(); ++c) {
    blobs_[c].clear();
    if ((truth_.delivered >> c & 1u) == 0) continue;
    discs.clear();
    const sim::SimCamera& from = scene_.camera(c, tick_);
    const double time_s = scene_.mid_exposure_s(c, tick_);
    for (std::uint32_t m = 0; m < scene_.markers(); ++m) {
      if ((truth_.markers[m].visible >> c & 1u) == 0) continue;
      from.outline(from.in_camera(scene_.marker(m, time_s).position_in_world), options_.sim.marker_radius_m,
                   outline);
      const sim::OutlineMoments shape = sim::moments(outline);
      const double radius = std::sqrt(shape.area_px2 / std::numbers::pi);
      const bool masked = std::ranges::any_of(scene_.spots(c), [&](const sim::BrightSpot& spot) {
        return std::hypot(shape.mean_px.x() - spot.x_px, shape.mean_px.y() - spot.y_px) <
               radius + spot.radius_px;
      });
      if (masked) continue;
      Disc disc{shape.mean_px, radius, shape.area_px2};
      // Discs that touch are one blob.
      for (std::size_t k = 0; k < discs.size();) {
        if ((discs[k].middle - disc.middle).norm() > discs[k].radius_px + disc.radius_px + 2.0) {
          ++k;
          continue;
        }
        const double area = disc.area_px2 + discs[k].area_px2;
        const Eigen::Vector2d middle =
            (disc.area_px2 * disc.middle + discs[k].area_px2 * discs[k].middle) / area;
        disc = {middle, std::sqrt(area / std::numbers::pi), area};
        discs.erase(discs.begin() + static_cast<std::ptrdiff_t>(k));
        k = 0;
      }
      discs.push_back(disc);
    }
    if (scene_.behind(c, tick_) != c) {  // its spots are not those that were learnt
      for (const sim::BrightSpot& spot : scene_.spots(scene_.behind(c, tick_)))
        discs.push_back({{spot.x_px, spot.y_px}, spot.radius_px, 3.0 * spot.radius_px * spot.radius_px});
    }
    for (const Eigen::Vector2d& spot : clutter_[c]) discs.push_back({spot, 2.0, 12.0});
    for (const Disc& disc : discs) {
      const Eigen::Vector2d pixel =
          disc.middle + options_.centroid_px * Eigen::Vector2d(static_cast<double>(normal_.draw(random_)),
                                                               static_cast<double>(normal_.draw(random_)));
      shaders::BlobRecord blob{};
      blob.camera = c;
      blob.area_px = static_cast<std::uint32_t>(std::lround(std::max(2.0, disc.area_px2)));
      blob.x_px = static_cast<float>(pixel.x());
      blob.y_px = static_cast<float>(pixel.y());
      const auto normalized = cameras_[c].undistort(pixel);
      if (!normalized) blob.flags |= shaders::kBlobNotInvertible;
      if (normalized) {
        blob.x_undist = static_cast<float>(normalized->x());
        blob.y_undist = static_cast<float>(normalized->y());
      }
      blobs_[c].push_back(blob);
    }
  }
}

void WatchedRig::run(double seconds) {
  std::vector<Prediction> predictions;
  std::vector<Point> points;
  std::vector<TrackedPoint> tracked;
  std::vector<WatchedMarker> markers;
  MatchCounters match_counters;
  TrackCounters track_counters;
  const auto end = tick_ + static_cast<std::uint64_t>(seconds * options_.sim.rate_hz);
  for (; tick_ < end; ++tick_) {
    make_blobs();
    const std::vector<std::span<const shaders::BlobRecord>> blobs(blobs_.begin(), blobs_.end());
    const double time_s = scene_.mid_exposure_s(tick_);
    const Timestamp exposed(std::chrono::nanoseconds(std::llround(time_s * 1e9)));
    tracker_.predict(exposed, predictions);
    matcher_.match(blobs, predictions, points, match_counters);
    tracker_.update(points, tracked, track_counters);
    markers.clear();
    for (const TrackedPoint& p : tracked)
      if (p.kind == SampleKind::Measured) markers.push_back({p.point, p.velocity_in_world});
    const double before_s = thread_cpu_s();
    health_.watch({exposed, truth_.delivered, blobs, points, markers});
    const double took_s = thread_cpu_s() - before_s;
    watch_s_ += took_s;
    longest_watch_s_ = std::max(longest_watch_s_, took_s);
    for (const HealthEvent& event : health_.events()) events_.push_back({time_s, event});
  }
}

std::string text_of(const std::vector<NamedEvent>& events) {
  std::string all;
  for (const NamedEvent& e : events) {
    const CameraState& s = e.event.state;
    constexpr std::array<const char*, 6> kNames{"unknown", "fine", "drifting", "bumped", "late", "swapped"};
    char text[160];
    std::snprintf(text, sizeof text,
                  "%.2f s: cam%zu %s (%.3f up %.3f right %.3f clockwise, %.2f px, %.2f ms, with cam%zu); ",
                  e.time_s, index(e.event.camera) + 1, kNames[static_cast<std::size_t>(s.condition)],
                  s.turn_rad.x() * 180 / std::numbers::pi, s.turn_rad.y() * 180 / std::numbers::pi,
                  s.turn_rad.z() * 180 / std::numbers::pi, s.offset_px, s.late_s * 1e3,
                  index(s.swapped_with) + 1);
    all += text;
  }
  return all;
}

}  // namespace glint::testing
