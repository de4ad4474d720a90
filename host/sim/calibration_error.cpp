// SPDX-License-Identifier: MIT
// Poses that are wrong by a wanted number of pixels.
#include "host/sim/calibration_error.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "host/base/error.hpp"
#include "host/sim/motion.hpp"
#include "host/sim/random.hpp"

namespace glint {
namespace {

/// Points of the volume, 0.25 m apart, and their pixels in one camera.
struct SeenGrid {
  explicit SeenGrid(const CameraCalibration& calibration) {
    const Camera camera(calibration);
    const sim::Volume volume;
    constexpr double kStep_m = 0.25;
    for (double x = -volume.half_width_m; x <= volume.half_width_m; x += kStep_m) {
      for (double y = -volume.half_width_m; y <= volume.half_width_m; y += kStep_m) {
        for (double z = volume.floor_m; z <= volume.ceiling_m; z += kStep_m) {
          const auto pixel = camera.project({x, y, z});
          if (!pixel || !camera.inside(*pixel)) continue;
          points.emplace_back(x, y, z);
          pixels.push_back(*pixel);
        }
      }
    }
  }
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector2d> pixels;
};

/// Turned about its own axes and shifted by its own coordinates.
CameraCalibration moved(const CameraCalibration& camera, const Eigen::Vector3d& turn_rad,
                        const Eigen::Vector3d& shift_m) {
  CameraCalibration other = camera;
  Pose& pose = other.world_from_camera;
  const double angle = turn_rad.norm();
  if (angle > 0.0) {
    const Eigen::Quaterniond turn(Eigen::AngleAxisd(angle, turn_rad / angle));
    pose.rotation = (camera.world_from_camera.rotation * turn).normalized();
  }
  pose.translation += camera.world_from_camera.rotation * shift_m;
  return other;
}

double rms_shift_px(const CameraCalibration& camera, const SeenGrid& seen) {
  const Camera other(camera);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < seen.points.size(); ++i) {
    const auto pixel = other.project(seen.points[i]);
    if (!pixel) continue;
    sum += (*pixel - seen.pixels[i]).squaredNorm();
    ++count;
  }
  return std::sqrt(sum / static_cast<double>(count));
}

Eigen::Vector3d normal_vector(sim::Random& random, const sim::NormalTable& normal) {
  Eigen::Vector3d vector;
  for (double& value : vector) value = static_cast<double>(normal.draw(random));
  return vector;
}

CameraCalibration disturbed(const CameraCalibration& exact, double error_px, sim::Random& random,
                            const sim::NormalTable& normal) {
  const SeenGrid seen(exact);
  if (seen.points.empty()) {
    throw Error("calibration error: camera " + exact.name + " sees nothing of the simulated volume");
  }
  // Shares as small motions have them, then both together to the wanted size.
  constexpr double kSmall = 1e-5;
  const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
  Eigen::Vector3d turn = kSmall * normal_vector(random, normal);
  Eigen::Vector3d shift = kSmall * normal_vector(random, normal);
  turn /= rms_shift_px(moved(exact, turn, zero), seen);
  shift /= rms_shift_px(moved(exact, zero, shift), seen);
  double scale = error_px;
  for (int i = 0; i < 8; ++i) {  // nearly linear: three would do
    scale *= error_px / rms_shift_px(moved(exact, scale * turn, scale * shift), seen);
  }
  CameraCalibration result = moved(exact, scale * turn, scale * shift);
  result.rms_px = error_px;
  return result;
}

}  // namespace

Calibration disturbed(const Calibration& exact, double error_px, std::uint64_t seed) {
  Calibration result = exact;
  if (error_px <= 0.0) return result;
  const sim::NormalTable normal;
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    sim::Random random(sim::stream_seed(seed, sim::Stream::CalibrationError, c));
    result.cameras[c] = disturbed(exact.cameras[c], error_px, random, normal);
  }
  return result;
}

}  // namespace glint
