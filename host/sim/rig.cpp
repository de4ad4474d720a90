// SPDX-License-Identifier: MIT
// Poses and lenses of the simulated rig.
#include "host/sim/rig.hpp"

#include <cmath>
#include <numbers>
#include <string>

#include "host/sim/random.hpp"

namespace glint {
namespace {

constexpr double kHalfRoom_m = 2.5;
constexpr double kMountHeight_m = 2.4;
constexpr double kAimHeight_m = 1.0;
constexpr double kWidthOfFocal_px = 1280.0;  // focal lengths below are for this image width

double either_sign(sim::Random& random, double low, double high) {
  const double size = random.uniform(low, high);
  return random.uniform() < 0.5 ? -size : size;
}

Pose look_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at, double roll_rad) {
  const Eigen::Vector3d forward = (at - from).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d world_from_camera;
  world_from_camera.col(0) = right;
  world_from_camera.col(1) = forward.cross(right);
  world_from_camera.col(2) = forward;
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  return {(Eigen::Quaterniond(world_from_camera) * roll).normalized(), from};
}

}  // namespace

Calibration sim_calibration(const SimOptions& options) {
  Calibration calibration;
  calibration.made_at = "1970-01-01T00:00:00Z";
  calibration.made_from = "simulated rig, seed " + std::to_string(options.seed);
  const unsigned places = options.cameras <= 4 ? 4 : options.cameras;
  for (std::uint32_t i = 0; i < options.cameras; ++i) {
    sim::Random random(sim::stream_seed(options.seed, sim::Stream::Rig, i));
    CameraCalibration camera;
    camera.name = "cam" + std::to_string(i + 1);
    camera.width_px = options.width_px;
    camera.height_px = options.height_px;
    const double scale = options.width_px / kWidthOfFocal_px;
    camera.fx_px = random.uniform(914.0, 933.0) * scale;
    camera.fy_px = camera.fx_px * random.uniform(0.9995, 1.0005);
    camera.cx_px = (options.width_px - 1) / 2.0 + random.uniform(-12.0, 12.0) * scale;
    camera.cy_px = (options.height_px - 1) / 2.0 + random.uniform(-12.0, 12.0) * scale;
    camera.k1_k2_p1_p2_k3 = {random.uniform(-0.325, -0.315), random.uniform(0.115, 0.125),
                             random.uniform(-5e-4, 5e-4), random.uniform(-5e-4, 5e-4),
                             random.uniform(-0.021, -0.019)};
    const double angle = 2.0 * std::numbers::pi * (0.5 + i) / places;
    const double radius = kHalfRoom_m * std::numbers::sqrt2;
    const Eigen::Vector3d from(radius * std::cos(angle) + either_sign(random, 0.01, 0.05),
                               radius * std::sin(angle) + either_sign(random, 0.01, 0.05),
                               kMountHeight_m + either_sign(random, 0.01, 0.05));
    const Eigen::Vector3d at(either_sign(random, 0.01, 0.05), either_sign(random, 0.01, 0.05),
                             kAimHeight_m + either_sign(random, 0.01, 0.05));
    camera.world_from_camera = look_at(from, at, random.uniform(-0.02, 0.02));
    calibration.cameras.push_back(camera);
  }
  return calibration;
}

}  // namespace glint
