// SPDX-License-Identifier: MIT
// Matcher and tracker in their loop: markers that fly through the rig, merge in single images, hide and
// bounce.
#include <gtest/gtest.h>

#include <cstdio>
#include <map>
#include <numeric>
#include <set>

#include "host/track/tracker.hpp"
#include "tests/unit/match/scene.hpp"

namespace glint {
namespace {

using namespace testing;

constexpr double kRate_hz = 90.0;
constexpr double kMarkerRadius_m = 0.0063;

struct Flight {
  std::vector<Eigen::Vector3d> position, velocity;

  Flight(std::size_t markers, double speed_m_s, std::mt19937_64& random)
      : position(scattered(random, markers)) {
    for (std::size_t k = 0; k < markers; ++k) {
      const Eigen::Vector3d v(uniform(random, -1, 1), uniform(random, -1, 1), uniform(random, -1, 1));
      velocity.push_back(uniform(random, 0.2, 1.0) * speed_m_s * v.normalized());
    }
  }
  void step() {
    for (std::size_t k = 0; k < position.size(); ++k) {
      position[k] += velocity[k] / kRate_hz;
      const Eigen::Vector3d low(-1.2, -1.2, 0.0), high(1.2, 1.2, 1.6);
      for (int axis = 0; axis < 3; ++axis) {
        if (position[k][axis] < low[axis]) {
          position[k][axis] = 2 * low[axis] - position[k][axis];
          velocity[k][axis] = std::abs(velocity[k][axis]);
        } else if (position[k][axis] > high[axis]) {
          position[k][axis] = 2 * high[axis] - position[k][axis];
          velocity[k][axis] = -std::abs(velocity[k][axis]);
        }
      }
    }
  }
};

/// Blobs with size and shape; where two lie closer than their radii allow they become one, as in a real
/// image.
Exposure expose_discs(const Calibration& rig, const std::vector<Eigen::Vector3d>& markers, double sigma_px,
                      double hidden, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Exposure exposure;
  for (const CameraCalibration& c : rig.cameras) {
    const Camera camera(c);
    struct Disc {
      Eigen::Vector2d centre;
      double radius, weight;
      int marker;
      Eigen::Matrix2d moments;
    };
    std::vector<Disc> discs;
    for (std::size_t m = 0; m < markers.size(); ++m) {
      const auto pixel = camera.project_pinhole(markers[m]);
      if (!pixel || !camera.inside(*pixel) || uniform(random, 0, 1) < hidden) continue;
      const double radius = c.fx_px * kMarkerRadius_m / camera.in_camera(markers[m]).z() + 0.4;
      discs.push_back({*pixel + sigma_px * Eigen::Vector2d(normal(random), normal(random)), radius,
                       radius * radius, static_cast<int>(m),
                       radius * radius / 4 * Eigen::Matrix2d::Identity()});
    }
    for (bool merged = true; merged;) {
      merged = false;
      for (std::size_t i = 0; i < discs.size() && !merged; ++i)
        for (std::size_t j = i + 1; j < discs.size() && !merged; ++j) {
          Disc &a = discs[i], &b = discs[j];
          const Eigen::Vector2d d = b.centre - a.centre;
          if (d.norm() > a.radius + b.radius + 0.5) continue;
          // Discs that cover each other count once where they do: less weight for the pair, about the same
          // moments.
          const double w = a.weight + b.weight, share = b.weight / w;
          a.moments = (1 - share) * a.moments + share * b.moments + share * (1 - share) * d * d.transpose();
          a.centre += share * d;
          const double apart = std::min(1.0, d.norm() / (a.radius + b.radius));
          a.weight = std::max(a.weight, b.weight) + apart * std::min(a.weight, b.weight);
          a.radius = std::sqrt(a.weight);
          discs.erase(discs.begin() + static_cast<std::ptrdiff_t>(j));
          merged = true;
        }
    }
    auto& blobs = exposure.blobs.emplace_back();
    auto& marker_of = exposure.marker_of.emplace_back();
    for (const Disc& disc : discs) {
      shaders::BlobRecord blob = blob_at(c, disc.centre);
      blob.area_px = static_cast<std::uint32_t>(std::lround(M_PI * disc.weight));
      blob.var_xx_px2 = static_cast<float>(disc.moments(0, 0));
      blob.var_xy_px2 = static_cast<float>(disc.moments(0, 1));
      blob.var_yy_px2 = static_cast<float>(disc.moments(1, 1));
      blobs.push_back(blob);
      marker_of.push_back(disc.marker);
    }
  }
  return exposure;
}

struct Result {
  double recall = 0, rms_mm = 0, worst_mm = 0;
  std::size_t ghosts = 0, points = 0, id_changes = 0;
};

Result fly(const char* name, std::size_t cameras, std::size_t markers, double speed_m_s, double hidden,
           int frames) {
  const Calibration rig = ring_rig(cameras, 3.5);
  MatchOptions match_options;
  match_options.marker_radius_m = 0.0;  // the blobs here are placed without the bias
  match_options.max_range_m = 10.0;
  Matcher matcher(rig, match_options);
  Tracker tracker{TrackOptions{}};
  std::mt19937_64 random(2024);
  Flight flight(markers, speed_m_s, random);
  std::vector<Prediction> predictions;
  std::vector<Point> points;
  std::vector<TrackedPoint> tracked;
  MatchCounters match_counters;
  TrackCounters track_counters;
  std::vector<TrackId> id_of(markers);
  std::vector<Camera> all(rig.cameras.begin(), rig.cameras.end());
  Result r;
  std::size_t seen = 0, found = 0;
  double squares = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const Exposure exposure = expose_discs(rig, flight.position, 0.015, hidden, random);
    tracker.predict(Timestamp(std::chrono::nanoseconds(static_cast<std::int64_t>(frame * 1e9 / kRate_hz))),
                    predictions);
    const auto blobs = exposure.spans();
    matcher.match(blobs, predictions, points, match_counters);
    tracker.update(points, tracked, track_counters);
    std::erase_if(tracked, [](const TrackedPoint& point) { return point.kind == SampleKind::Predicted; });
    std::vector<bool> taken(tracked.size(), false);
    for (std::size_t m = 0; m < markers; ++m) {
      std::size_t best = tracked.size();
      double nearest = 0.01;
      for (std::size_t k = 0; k < tracked.size(); ++k)
        if (const double d = (tracked[k].position_in_world - flight.position[m]).norm();
            !taken[k] && d < nearest) {
          nearest = d;
          best = k;
        }
      // Seen: two cameras show it in a blob of its own.
      if (exposure.views(static_cast<int>(m)) >= 2) {
        ++seen;
        if (best < tracked.size()) ++found;
      }
      if (best == tracked.size()) continue;
      taken[best] = true;
      squares += nearest * nearest;
      r.worst_mm = std::max(r.worst_mm, 1e3 * nearest);
      ++r.points;
      if (id_of[m] != TrackId{} && id_of[m] != tracked[best].id) ++r.id_changes;
      id_of[m] = tracked[best].id;
    }
    r.ghosts += static_cast<std::size_t>(std::count(taken.begin(), taken.end(), false));
    flight.step();
  }
  r.recall = static_cast<double>(found) / static_cast<double>(seen);
  r.rms_mm = 1e3 * std::sqrt(squares / static_cast<double>(r.points));
  std::printf(
      "%-22s %zu cameras %zu markers at up to %.0f m/s, %.0f %% hidden: recall %.5f (%zu lost), rms %.4f mm, "
      "worst "
      "%.2f mm, %zu ghosts of %zu, %zu id changes, %llu held back, %llu cut\n",
      name, cameras, markers, speed_m_s, 100 * hidden, r.recall, seen - found, r.rms_mm, r.worst_mm, r.ghosts,
      r.points, r.id_changes, static_cast<unsigned long long>(match_counters.held_back),
      static_cast<unsigned long long>(match_counters.hypotheses_cut));
  return r;
}

TEST(Flight, TwentyMarkersOnTheBuiltInRig) {
  const Result r = fly("built-in rig", 4, 20, 10.0, 0.0, 2700);
  EXPECT_GE(r.recall, 0.999);
  EXPECT_LE(static_cast<double>(r.ghosts), 1e-4 * static_cast<double>(r.points));
  EXPECT_LE(r.rms_mm, 0.08);
}

TEST(Flight, WithATenthHidden) {
  const Result r = fly("a tenth hidden", 4, 20, 10.0, 0.1, 1000);
  EXPECT_GE(r.recall, 0.995);
  EXPECT_LE(static_cast<double>(r.ghosts), 1e-3 * static_cast<double>(r.points));
}

TEST(Flight, TwoCamerasOnly) {
  const Result r = fly("two cameras", 2, 8, 3.0, 0.0, 500);
  EXPECT_GE(r.recall, 0.97);
}

TEST(Flight, Crowded) {
  const Result r = fly("crowded", 4, 64, 5.0, 0.05, 300);
  EXPECT_GE(r.recall, 0.99);
}

}  // namespace
}  // namespace glint
