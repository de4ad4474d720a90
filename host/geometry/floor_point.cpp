// SPDX-License-Identifier: MIT
// Ray and horizontal plane.
#include "host/geometry/floor_point.hpp"

#include <cmath>

#include "host/geometry/sphere_bias.hpp"

namespace glint {
namespace {

enum class Meeting { Meets, Behind, EdgeOn };

Meeting meeting_of(const Camera& camera, const Eigen::Vector3d& ray_in_world, double height_m) noexcept {
  const double rise_m = height_m - camera.position_in_world().z();
  if (!(rise_m * ray_in_world.z() > 0.0)) return Meeting::Behind;
  const double sine = std::abs(ray_in_world.z()) / ray_in_world.norm();
  return sine < std::sin(kLeastFloorAngle_rad) ? Meeting::EdgeOn : Meeting::Meets;
}

}  // namespace

std::optional<FloorPoint> floor_point(const Observation& view, double height_m, double marker_radius_m,
                                      double height_sd_m) noexcept {
  const Camera& camera = *view.camera;
  const Eigen::Matrix3d world_from_camera = camera.camera_from_world_rotation().transpose();
  const Eigen::Vector3d from = camera.position_in_world();
  Eigen::Vector2d normalized = view.normalized;
  Eigen::Vector3d ray;
  double depth_m = 0.0;
  // The ray's depth is the marker's, from which the sphere's bias follows, which moves the ray by less than a
  // thousandth: twice is enough.
  for (int step = 0; step < (marker_radius_m > 0.0 ? 3 : 1); ++step) {
    if (step > 0) normalized = remove_sphere_bias(view.normalized, marker_radius_m, depth_m);
    ray = world_from_camera * normalized.homogeneous();
    if (meeting_of(camera, ray, height_m) != Meeting::Meets) return std::nullopt;
    depth_m = (height_m - from.z()) / ray.z();
  }
  FloorPoint result;
  result.position_in_world = from + depth_m * ray;
  result.position_in_world.z() = height_m;
  // Sideways on the z = 1 plane, and then along the ray back to the height.
  const Eigen::Vector3d along = ray / ray.z();
  const Eigen::Matrix3d back = Eigen::Matrix3d::Identity() - along * Eigen::RowVector3d::UnitZ();
  Eigen::Matrix<double, 3, 2> by_pixel = depth_m * back * world_from_camera.leftCols<2>();
  by_pixel.col(0) /= camera.calibration().fx_px;
  by_pixel.col(1) /= camera.calibration().fy_px;
  result.covariance_m2 = by_pixel * view.covariance_px2 * by_pixel.transpose() +
                         height_sd_m * height_sd_m * along * along.transpose();
  if (!result.position_in_world.allFinite() || !result.covariance_m2.allFinite()) return std::nullopt;
  return result;
}

PlaneSight sight_of_plane(const Camera& camera, double height_m) noexcept {
  constexpr int kAcross = 8;  // parts of the image
  const CameraCalibration& c = camera.calibration();
  bool edge_on = false;
  for (int v = 0; v <= kAcross; ++v) {
    for (int u = 0; u <= kAcross; ++u) {
      const auto normalized =
          camera.undistort({u * (c.width_px - 1.0) / kAcross, v * (c.height_px - 1.0) / kAcross});
      if (!normalized) continue;
      const Meeting meeting = meeting_of(camera, camera.direction_in_world(*normalized), height_m);
      if (meeting == Meeting::Meets) return PlaneSight::Seen;
      edge_on = edge_on || meeting == Meeting::EdgeOn;
    }
  }
  return edge_on ? PlaneSight::EdgeOn : PlaneSight::Behind;
}

}  // namespace glint
