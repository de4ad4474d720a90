// SPDX-License-Identifier: MIT
// Fisher information of images and positions.
#include "host/sim/bound.hpp"

#include <bit>
#include <limits>

#include <Eigen/LU>

namespace glint {

PositionBound::PositionBound(const Scene& scene) : scene_(scene), noise_(scene.options()), painter_(scene) {}

Eigen::Matrix2d PositionBound::information_px(const TickTruth& truth, std::uint32_t camera,
                                              std::uint32_t marker) {
  constexpr float kRounding_grey2 = 1.0f / 12.0f, kClipped_grey = 254.5f;
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();
  const sim::Patch* patch = painter_.paint(camera, truth.tick, marker, truth.views_of(camera), true);
  if (patch == nullptr) return information;
  const sim::MarkerView& view = truth.views_of(camera)[marker];
  const float dark =
      noise_.black_grey +
      static_cast<float>(scene_.glow(scene_.behind(camera, truth.tick)).grey_at(view.x_px, view.y_px));
  float xx = 0.0f, xy = 0.0f, yy = 0.0f;
  for (int y = 0; y < patch->height_px(); ++y) {
    const float* light = patch->row(y);
    const float* by_x = patch->row_by_x(y);
    const float* by_y = patch->row_by_y(y);
    for (int x = 0; x < patch->width_px(); ++x) {
      const float grey = dark + light[x];
      const float weight =
          grey < kClipped_grey ? 1.0f / (noise_.variance_grey2(grey) + kRounding_grey2) : 0.0f;
      xx += by_x[x] * by_x[x] * weight;
      xy += by_x[x] * by_y[x] * weight;
      yy += by_y[x] * by_y[x] * weight;
    }
  }
  information << static_cast<double>(xx), static_cast<double>(xy), static_cast<double>(xy),
      static_cast<double>(yy);
  return information;
}

double PositionBound::variance_m2(const TickTruth& truth, std::uint32_t marker) {
  const MarkerTruth& ball = truth.markers[marker];
  if (std::popcount(ball.clean) < 2) return std::numeric_limits<double>::infinity();
  Eigen::Matrix3d information = Eigen::Matrix3d::Zero();
  for (std::uint32_t c = 0; c < scene_.cameras(); ++c) {
    if ((ball.clean & (1u << c)) == 0) continue;
    const sim::SimCamera& camera = scene_.camera(c, truth.tick);
    Eigen::Matrix<double, 2, 3> by_camera;
    camera.project(camera.in_camera(ball.position_in_world), &by_camera);
    const Eigen::Matrix<double, 2, 3> by_world = by_camera * camera.camera_from_world_rotation();
    information += by_world.transpose() * information_px(truth, c, marker) * by_world;
  }
  bool invertible = false;
  Eigen::Matrix3d covariance;
  double determinant = 0.0;
  information.computeInverseAndDetWithCheck(covariance, determinant, invertible, 1e-9);
  return invertible ? covariance.trace() : std::numeric_limits<double>::infinity();
}

}  // namespace glint
