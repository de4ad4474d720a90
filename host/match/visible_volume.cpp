// SPDX-License-Identifier: MIT
// Volume seen by two or more cameras.
#include "host/match/visible_volume.hpp"

#include <algorithm>
#include <cmath>

#include <Eigen/Eigenvalues>

namespace glint {
namespace {

// Where the views' middles meet, in the sense of least squares, and a range that reaches as far behind it as
// it is away. Without this a generous max_range_m would put most of the volume where nobody tracks.
double useful_range_m(std::span<const Camera> cameras, double max_range_m) {
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const Camera& camera : cameras) {
    const CameraCalibration& c = camera.calibration();
    const auto middle = camera.undistort({0.5 * (c.width_px - 1.0), 0.5 * (c.height_px - 1.0)});
    if (!middle) return max_range_m;
    const Eigen::Vector3d d = camera.direction_in_world(*middle);
    const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - d * d.transpose();
    a += across;
    b += across * camera.position_in_world();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(a);
  if (!(solver.eigenvalues()[0] > 1e-3 * static_cast<double>(cameras.size())))
    return max_range_m;  // parallel views
  const Eigen::Vector3d meeting = solver.eigenvectors() * solver.eigenvalues().cwiseInverse().asDiagonal() *
                                  solver.eigenvectors().transpose() * b;
  double range = 0.0;
  for (const Camera& camera : cameras) range = std::max(range, (meeting - camera.position_in_world()).norm());
  return std::min(max_range_m, 2.0 * range);
}

}  // namespace

bool sees(const Camera& camera, const Eigen::Vector3d& point_in_world, double margin_px, double min_range_m,
          double max_range_m) noexcept {
  const double range2 = (point_in_world - camera.position_in_world()).squaredNorm();
  if (range2 < min_range_m * min_range_m || range2 > max_range_m * max_range_m) return false;
  // Far outside of the image some lens models fold back into it: ask the pinhole first, generously.
  const auto pinhole = camera.project_pinhole(point_in_world);
  const CameraCalibration& c = camera.calibration();
  if (!pinhole || !camera.inside(*pinhole, -0.5 * static_cast<double>(std::max(c.width_px, c.height_px))))
    return false;
  const auto pixel = camera.project(point_in_world);
  return pixel && camera.inside(*pixel, margin_px);
}

double visible_volume_m3(std::span<const Camera> cameras, double min_range_m, double max_range_m) {
  constexpr int kAcross = 8,
                kDeep = 256;  // 2.7 % steps of depth from 0.1 to 100 m: only the logarithm is used
  if (cameras.empty()) return 1.0;
  max_range_m = std::max(useful_range_m(cameras, max_range_m), 1.01 * min_range_m);
  const double ratio = std::pow(max_range_m / min_range_m, 1.0 / kDeep);
  double largest = 0.0;
  for (const Camera& camera : cameras) {
    const CameraCalibration& c = camera.calibration();
    double volume = 0.0;
    for (int v = 0; v < kAcross; ++v)
      for (int u = 0; u < kAcross; ++u) {
        const Eigen::Vector2d pixel((u + 0.5) / kAcross * c.width_px - 0.5,
                                    (v + 0.5) / kAcross * c.height_px - 0.5);
        const auto normalized = camera.undistort(pixel);
        if (!normalized) continue;
        const Eigen::Vector3d direction = camera.direction_in_world(*normalized);
        // Solid angle of the patch: its area on the z = 1 plane times cos^3 of the angle off the axis.
        const double solid_angle = c.width_px * (c.height_px / std::abs(c.fx_px * c.fy_px)) /
                                   (kAcross * kAcross) / std::pow(1.0 + normalized->squaredNorm(), 1.5);
        double range = min_range_m * std::sqrt(ratio);
        for (int d = 0; d < kDeep; ++d, range *= ratio) {
          const Eigen::Vector3d point = camera.position_in_world() + range * direction;
          const bool shared = std::any_of(cameras.begin(), cameras.end(), [&](const Camera& other) {
            return &other != &camera && sees(other, point, 0.0, min_range_m, max_range_m);
          });
          if (shared) volume += solid_angle * range * range * range * std::log(ratio);
        }
      }
    largest = std::max(largest, volume);
  }
  return std::max(largest, 1e-9);
}

}  // namespace glint
