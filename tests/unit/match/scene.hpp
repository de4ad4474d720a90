// SPDX-License-Identifier: MIT
// A made-up rig and its blobs, with the truth, for the tests of matching and tracking.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>
#include <vector>

#include "host/match/matcher.hpp"

namespace glint::testing {

inline double uniform(std::mt19937_64& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

inline Pose looking_at(const Eigen::Vector3d& position, const Eigen::Vector3d& target) {
  const Eigen::Vector3d z = (target - position).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d rotation;
  rotation.col(0) = x;
  rotation.col(1) = z.cross(x);
  rotation.col(2) = z;
  return {Eigen::Quaterniond(rotation), position};
}

/// Cameras on a circle 4.2 m wide in radius, 2 m high, f = 914 px, 1280x800, looking at the middle of the
/// volume.
inline Calibration ring_rig(std::size_t cameras, double radius_m = 4.2) {
  Calibration calibration;
  for (std::size_t k = 0; k < cameras; ++k) {
    CameraCalibration c;
    c.name = std::to_string(k);
    c.width_px = 1280;
    c.height_px = 800;
    c.fx_px = c.fy_px = 914;
    c.cx_px = 639.5;
    c.cy_px = 399.5;
    // Not quite regular, so that no two cameras face each other exactly.
    const double angle =
        2 * M_PI * static_cast<double>(k) / static_cast<double>(cameras) + 0.07 * static_cast<double>(k % 3);
    c.world_from_camera =
        looking_at({radius_m * std::cos(angle), radius_m * std::sin(angle), 2.0}, {0, 0, 0.8});
    calibration.cameras.push_back(c);
  }
  return calibration;
}

/// Uniform in 2.4 x 2.4 x 1.6 m on the floor.
inline std::vector<Eigen::Vector3d> scattered(std::mt19937_64& random, std::size_t count) {
  std::vector<Eigen::Vector3d> points(count);
  for (auto& p : points)
    p = {uniform(random, -1.2, 1.2), uniform(random, -1.2, 1.2), uniform(random, 0.0, 1.6)};
  return points;
}

/// Bodies of five markers within 0.2 m.
inline std::vector<Eigen::Vector3d> clustered(std::mt19937_64& random, std::size_t count) {
  std::vector<Eigen::Vector3d> points;
  while (points.size() < count) {
    const Eigen::Vector3d body(uniform(random, -1.1, 1.1), uniform(random, -1.1, 1.1),
                               uniform(random, 0.1, 1.5));
    for (int k = 0; k < 5 && points.size() < count; ++k)
      points.push_back(body + Eigen::Vector3d(uniform(random, -0.1, 0.1), uniform(random, -0.1, 0.1),
                                              uniform(random, -0.1, 0.1)));
  }
  return points;
}

struct Noise {
  double centroid_px = 0.0;     ///< per axis
  double missing = 0.0;         ///< share of a camera's blobs that are not there
  double calibration_px = 0.0;  ///< a fixed error of each camera, per axis
  std::size_t clutter = 0;      ///< blobs of no marker, per camera
};

/// Blobs of all cameras, and which marker each is of (-1: clutter).
struct Exposure {
  std::vector<std::vector<shaders::BlobRecord>> blobs;
  std::vector<std::vector<int>> marker_of;

  std::vector<std::span<const shaders::BlobRecord>> spans() const { return {blobs.begin(), blobs.end()}; }
  int views(int marker) const {
    int count = 0;
    for (const auto& list : marker_of)
      count += static_cast<int>(std::count(list.begin(), list.end(), marker));
    return count;
  }
};

inline shaders::BlobRecord blob_at(const CameraCalibration& c, const Eigen::Vector2d& pinhole_px) {
  shaders::BlobRecord blob{};
  blob.x_px = static_cast<float>(pinhole_px.x());
  blob.y_px = static_cast<float>(pinhole_px.y());
  blob.x_undist = static_cast<float>((pinhole_px.x() - c.cx_px) / c.fx_px);
  blob.y_undist = static_cast<float>((pinhole_px.y() - c.cy_px) / c.fy_px);
  return blob;
}

inline Exposure expose(const Calibration& calibration, const std::vector<Eigen::Vector3d>& markers,
                       const Noise& noise, std::mt19937_64& random) {
  std::normal_distribution<double> normal;
  Exposure exposure;
  for (const CameraCalibration& c : calibration.cameras) {
    const Camera camera(c);
    auto& blobs = exposure.blobs.emplace_back();
    auto& marker_of = exposure.marker_of.emplace_back();
    const Eigen::Vector2d offset = noise.calibration_px * Eigen::Vector2d(normal(random), normal(random));
    for (std::size_t m = 0; m < markers.size(); ++m) {
      const auto pixel = camera.project_pinhole(markers[m]);
      if (!pixel || !camera.inside(*pixel) || uniform(random, 0, 1) < noise.missing) continue;
      blobs.push_back(
          blob_at(c, *pixel + offset + noise.centroid_px * Eigen::Vector2d(normal(random), normal(random))));
      marker_of.push_back(static_cast<int>(m));
    }
    for (std::size_t k = 0; k < noise.clutter; ++k) {
      blobs.push_back(blob_at(c, {uniform(random, 0, c.width_px - 1), uniform(random, 0, c.height_px - 1)}));
      marker_of.push_back(-1);
    }
  }
  return exposure;
}

struct Score {
  std::size_t seen = 0;    ///< markers with blobs in two or more cameras
  std::size_t found = 0;   ///< of those, with a point within 10 mm
  std::size_t ghosts = 0;  ///< points that are nobody's
  std::size_t mixed = 0;   ///< points with blobs of different markers
  double recall() const { return seen == 0 ? 1.0 : static_cast<double>(found) / static_cast<double>(seen); }
  void operator+=(const Score& other) {
    seen += other.seen;
    found += other.found;
    ghosts += other.ghosts;
    mixed += other.mixed;
  }
};

inline Score score(const Exposure& exposure, const std::vector<Eigen::Vector3d>& markers,
                   const std::vector<Point>& points, double within_m = 0.01, int min_views = 2) {
  Score s;
  std::vector<bool> taken(points.size(), false);
  for (std::size_t m = 0; m < markers.size(); ++m) {
    const bool counts = exposure.views(static_cast<int>(m)) >= min_views;
    s.seen += counts ? 1u : 0u;
    std::optional<std::size_t> best;
    for (std::size_t k = 0; k < points.size(); ++k) {
      const double d = (points[k].position_in_world - markers[m]).norm();
      if (!taken[k] && d < within_m && (!best || d < (points[*best].position_in_world - markers[m]).norm()))
        best = k;
    }
    if (!best) continue;
    taken[*best] = true;
    s.found += counts ? 1u : 0u;
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    if (!taken[k]) ++s.ghosts;
    int marker = -2;
    bool mixed = false;
    for (std::size_t c = 0; c < exposure.blobs.size(); ++c) {
      if (points[k].blob_of_camera[c] < 0) continue;
      const int of = exposure.marker_of[c][static_cast<std::size_t>(points[k].blob_of_camera[c])];
      mixed = mixed || (marker != -2 && of != marker);
      marker = of;
    }
    s.mixed += mixed ? 1u : 0u;
  }
  return s;
}

}  // namespace glint::testing
