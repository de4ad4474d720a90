// SPDX-License-Identifier: MIT
// Samples of a target that is waved before the simulated rig, and how far cameras are from the truth.
#pragma once

#include <Eigen/Geometry>

#include "host/calibrate/samples.hpp"
#include "host/sim/rig.hpp"
#include "host/sim/wand_sightings.hpp"

namespace glint::test {

inline std::vector<SampleCamera> sample_cameras(const Calibration& rig) {
  std::vector<SampleCamera> cameras;
  for (const CameraCalibration& c : rig.cameras) cameras.push_back({c.name, c.width_px, c.height_px});
  return cameras;
}

inline SampleSet wave(const Calibration& rig, const Target& target, std::size_t ticks, double sigma_px,
                      std::uint64_t seed = 1, double period_s = 0.1) {
  SimOptions options;
  options.seed = seed;
  options.marker_radius_m = target.marker_radius_m;
  for (const Eigen::Vector3d& point : target.points_in_target) options.wand_m.push_back(point.x());
  SampleSet samples;
  samples.target = target;
  samples.cameras = sample_cameras(rig);
  samples.rate_hz = 1.0 / period_s;
  for (const WandSighting& s : wand_sightings(rig, options, {ticks, period_s, sigma_px}))
    samples.sightings.push_back({s.tick, s.camera, s.point, s.pixel});
  return samples;
}

/// Farthest distance of a camera from its true place, after the best alignment of all.
inline double worst_position_m(const Calibration& found, const Calibration& truth) {
  const auto count = static_cast<Eigen::Index>(found.cameras.size());
  Eigen::Matrix3Xd from(3, count), to(3, count);
  for (Eigen::Index c = 0; c < count; ++c) {
    from.col(c) = found.cameras[static_cast<std::size_t>(c)].world_from_camera.translation;
    to.col(c) = truth.cameras[static_cast<std::size_t>(c)].world_from_camera.translation;
  }
  const Eigen::Matrix4d t = Eigen::umeyama(from, to, false);
  const Eigen::Matrix3Xd moved =
      (t.topLeftCorner<3, 3>() * from).colwise() + Eigen::Vector3d(t.topRightCorner<3, 1>());
  return (moved - to).colwise().norm().maxCoeff();
}

}  // namespace glint::test
