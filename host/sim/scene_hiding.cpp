// SPDX-License-Identifier: MIT
// What of a marker is hidden by other markers, poles and the person.
#include <algorithm>
#include <cmath>

#include "host/sim/scene.hpp"

namespace glint {
namespace {

/// The disc that a camera sees of a ball: where the tangent cone touches it.
struct Disc {
  Disc(const Eigen::Vector3d& ball_in_camera, double ball_radius_m) noexcept {
    const double distance = ball_in_camera.norm();
    const double sine = ball_radius_m / distance;
    const double radius = ball_radius_m * std::sqrt(1.0 - sine * sine);
    const Eigen::Vector3d side = ball_in_camera.unitOrthogonal();
    centre = ball_in_camera * (1.0 - sine * sine);
    right = radius * side;
    down = radius * (ball_in_camera / distance).cross(side);
  }
  /// Sunflower seeds: even over the disc (Vogel, Math. Biosci. 44, 1979).
  Eigen::Vector3d point(std::size_t i, std::size_t count) const noexcept {
    constexpr double kGoldenAngle = 2.399963229728653;
    const double index = static_cast<double>(i);
    const double radius = std::sqrt((index + 0.5) / static_cast<double>(count)), angle = index * kGoldenAngle;
    return centre + radius * (std::cos(angle) * right + std::sin(angle) * down);
  }
  Eigen::Vector3d centre, right, down;
};

}  // namespace

bool Scene::may_be_hidden(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                          std::span<const sim::MarkerView> views) const noexcept {
  const sim::MarkerView& own = views[marker];
  for (std::uint32_t m = 0; m < options_.markers; ++m) {
    const sim::MarkerView& other = views[m];
    if (m == marker || !other.imaged || other.distance_m >= own.distance_m) continue;
    const double reach = own.radius_px + other.radius_px + 1.0;
    if (std::abs(own.x_px - other.x_px) < reach && std::abs(own.y_px - other.y_px) < reach) return true;
  }
  if (poles_.empty() && !person_) return false;
  const Eigen::Vector3d eye = this->camera(camera, tick).position_in_world();
  const double time_s = mid_exposure_s(camera, tick);
  const sim::MarkerState ball = this->marker(marker, time_s);
  // The ray to the middle against something that is fatter and higher by the ball and its motion.
  const double speed_m_s = std::max(options_.max_speed_m_s, ball.velocity_in_world.norm());
  const double grow = options_.marker_radius_m + options_.exposure_s * speed_m_s;
  if (person_ && person_->at(wand_middle(time_s), time_s).grown(grow).blocks(eye, ball.position_in_world)) {
    return true;
  }
  return std::any_of(poles_.begin(), poles_.end(), [&](const sim::Pole& pole) {
    const sim::Pole larger{pole.x_m, pole.y_m, pole.radius_m + grow, pole.height_m + grow};
    return blocks(larger, eye, ball.position_in_world);
  });
}

void Scene::fill_samples(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker, double time_s,
                         std::span<const sim::MarkerView> views,
                         std::span<DiscSample> samples) const noexcept {
  const sim::SimCamera& from = this->camera(camera, tick);
  const sim::MarkerView& own = views[marker];
  const double radius2_m2 = options_.marker_radius_m * options_.marker_radius_m;
  const Disc disc(from.in_camera(position(marker, time_s)), options_.marker_radius_m);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = {disc.point(i, samples.size()), false};
  for (std::uint32_t m = 0; m < options_.markers; ++m) {
    const sim::MarkerView& other = views[m];
    if (m == marker || !other.imaged || other.distance_m >= own.distance_m) continue;
    const double reach = own.radius_px + other.radius_px + 1.0;
    if (std::abs(own.x_px - other.x_px) > reach || std::abs(own.y_px - other.y_px) > reach) continue;
    const Eigen::Vector3d centre = from.in_camera(position(m, time_s));
    for (DiscSample& sample : samples) {
      const Eigen::Vector3d ray = sample.point_in_camera.normalized();
      sample.hidden = sample.hidden || centre.cross(ray).squaredNorm() < radius2_m2;
    }
  }
  if (poles_.empty() && !person_) return;
  const Eigen::Vector3d eye = from.position_in_world();
  const Eigen::Matrix3d world_from_camera = from.camera_from_world_rotation().transpose();
  std::optional<sim::PersonShape> person;
  if (person_) person = person_->at(wand_middle(time_s), time_s);
  for (DiscSample& sample : samples) {
    if (sample.hidden) continue;
    const Eigen::Vector3d point = eye + world_from_camera * sample.point_in_camera;
    sample.hidden = (person && person->blocks(eye, point)) ||
                    std::any_of(poles_.begin(), poles_.end(),
                                [&](const sim::Pole& pole) { return blocks(pole, eye, point); });
  }
}

}  // namespace glint
