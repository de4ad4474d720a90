// SPDX-License-Identifier: MIT
// What the cameras of a point really show at its place.
#include "host/sim/mixed_points.hpp"

#include <algorithm>

namespace glint::sim {

MixedPoints::MixedPoints(const Scene& scene, double gate_px)
    : scene_(scene), gate_px_(gate_px), times_shown_(scene.markers()) {}

bool MixedPoints::shown(const TickTruth& truth, std::uint32_t camera, std::uint32_t marker) const {
  constexpr unsigned kDiscPoints = 50;
  if ((truth.markers[marker].visible >> camera & 1u) != 0) return true;
  const MarkerView& view = truth.views_of(camera)[marker];
  const double right_px = static_cast<double>(scene_.options().width_px) - 0.5;
  const double bottom_px = static_cast<double>(scene_.options().height_px) - 0.5;
  if (view.x_px + view.half_width_px < -0.5 || view.x_px - view.half_width_px > right_px ||
      view.y_px + view.half_height_px < -0.5 || view.y_px - view.half_height_px > bottom_px) {
    return false;
  }
  unsigned seen = 0;
  scene_.sample_disc(camera, truth.tick, marker, scene_.mid_exposure_s(camera, truth.tick),
                     truth.views_of(camera), kDiscPoints,
                     [&](const Eigen::Vector3d&, bool hidden) { seen += hidden ? 0u : 1u; });
  return seen > 0;
}

bool MixedPoints::mixed(const TickTruth& truth, const Eigen::Vector3d& position_in_world,
                        std::uint32_t cameras) {
  std::fill(times_shown_.begin(), times_shown_.end(), 0u);
  std::uint32_t showing = 0;
  for (std::uint32_t c = 0; c < scene_.cameras(); ++c) {
    if (((cameras & truth.delivered) >> c & 1u) == 0) continue;
    const SimCamera& camera = scene_.camera(c, truth.tick);
    const Eigen::Vector3d in_camera = camera.in_camera(position_in_world);
    if (!camera.images(in_camera, scene_.options().marker_radius_m)) continue;
    const Eigen::Vector2d pixel = camera.project(in_camera);
    bool any = false;
    for (std::uint32_t m = 0; m < truth.markers.size(); ++m) {
      const MarkerView& view = truth.views_of(c)[m];
      if (!view.imaged) continue;
      const double reach_px = gate_px_ + view.radius_px;
      const Eigen::Vector2d off_px(view.x_px - pixel.x(), view.y_px - pixel.y());
      if (off_px.squaredNorm() > reach_px * reach_px || !shown(truth, c, m)) continue;
      ++times_shown_[m];
      any = true;
    }
    showing += any ? 1u : 0u;
  }
  return showing >= 2 && std::none_of(times_shown_.begin(), times_shown_.end(),
                                      [&](std::uint32_t times) { return times == showing; });
}

}  // namespace glint::sim
