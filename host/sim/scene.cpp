// SPDX-License-Identifier: MIT
// Truth per tick: positions, visibility, occlusion.
#include "host/sim/scene.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "host/base/error.hpp"
#include "host/sim/faults.hpp"
#include "host/sim/random.hpp"
#include "host/sim/rig.hpp"

namespace glint {
namespace {

constexpr double kFrameMargin_px = 2.0;  // of blur that must stay inside the frame
constexpr double kApart_px = 4.0;        // less, and a low threshold joins two blobs
constexpr double kHiddenShare = 0.2;     // of a seen marker's disc
constexpr unsigned kDiscSamples = 64;
constexpr unsigned kOutlinePoints = 16;  // its bounding box is within 2 % of the radius

/// Whether the vertical cylinder blocks the segment.
bool blocks(const sim::Pole& pole, const Eigen::Vector3d& from, const Eigen::Vector3d& to) noexcept {
  const double dx = to.x() - from.x(), dy = to.y() - from.y();
  const double fx = from.x() - pole.x_m, fy = from.y() - pole.y_m;
  const double a = dx * dx + dy * dy, b = fx * dx + fy * dy,
               c = fx * fx + fy * fy - pole.radius_m * pole.radius_m;
  const double discriminant = b * b - a * c;
  if (discriminant <= 0.0 || a <= 0.0) return false;
  const double root = std::sqrt(discriminant);
  const double enter = std::max(0.0, (-b - root) / a), leave = std::min(1.0, (-b + root) / a);
  if (enter >= leave) return false;
  const double dz = to.z() - from.z();
  return std::min(from.z() + enter * dz, from.z() + leave * dz) < pole.height_m;
}

std::vector<sim::BrightSpot> place_spots(const SimOptions& options, std::uint32_t camera) {
  sim::Random random(sim::stream_seed(options.seed, sim::Stream::Spots, camera));
  std::vector<sim::BrightSpot> spots;
  for (std::uint32_t i = 0; i < options.bright_spots; ++i) {
    sim::BrightSpot spot;
    spot.x_px = random.uniform(0.0, options.width_px - 1.0);
    spot.y_px = random.uniform(0.0, options.height_px - 1.0);
    spot.radius_px = random.uniform(1.0, 6.0);
    spot.grey = random.uniform(60.0, 200.0);
    spots.push_back(spot);
  }
  return spots;
}

sim::Glow place_glow(const SimOptions& options, std::uint32_t camera) {
  sim::Random random(sim::stream_seed(options.seed, sim::Stream::Spots, camera, 1));
  const double x = random.uniform(0.0, options.width_px), y = random.uniform(0.0, options.height_px);
  return {x, y, static_cast<double>(options.width_px)};
}

std::vector<sim::Pole> place_poles(const SimOptions& options, const sim::Volume& volume) {
  sim::Random random(sim::stream_seed(options.seed, sim::Stream::Poles));
  std::vector<sim::Pole> poles;
  for (std::uint32_t i = 0; i < options.occluders; ++i) {
    const double x = random.uniform(-volume.half_width_m, volume.half_width_m);
    const double y = random.uniform(-volume.half_width_m, volume.half_width_m);
    poles.push_back({x, y, random.uniform(0.02, 0.08), random.uniform(1.0, 2.2)});
  }
  return poles;
}

}  // namespace

Scene::Scene(const SimOptions& options) : options_(options) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) {
    std::string text = "simulated rig:";
    for (const std::string& problem : problems) text += " " + problem + ";";
    text.pop_back();
    throw Error(text);
  }
  calibration_ = sim_calibration(options);
  if (options.code_seed != 0) {
    code_.emplace(options.code_seed, PulseCode::group_for(options.code_group, options.rate_hz));
  }
  if (options.wand_m.empty()) {
    flights_ = sim::throw_markers(options, volume_);
  } else {
    dance_.emplace(options, volume_);
  }
  for (std::uint32_t c = 0; c < options.cameras; ++c) {
    cameras_.emplace_back(calibration_.cameras[c]);
    spots_.push_back(place_spots(options, c));
    glows_.push_back(place_glow(options, c));
  }
  if (options.faults.bump) {
    bumped_.push_back(cameras_[options.faults.bump->camera].turned(options.faults.bump->angle_rad));
  }
  poles_ = place_poles(options, volume_);
}

double Scene::mid_exposure_s(std::uint32_t camera, std::uint64_t tick) const noexcept {
  const auto& delay = options_.faults.delay;
  const bool delayed = delay && delay->camera == camera && tick >= delay->tick;
  return mid_exposure_s(tick) + (delayed ? delay->delay_s : 0.0);
}

std::uint32_t Scene::behind(std::uint32_t camera, std::uint64_t tick) const noexcept {
  const auto& swap = options_.faults.swap;
  if (!swap || tick < swap->tick) return camera;
  return camera == swap->camera ? swap->other : camera == swap->other ? swap->camera : camera;
}

const sim::SimCamera& Scene::camera(std::uint32_t camera, std::uint64_t tick) const noexcept {
  const auto& bump = options_.faults.bump;
  const std::uint32_t taken_by = behind(camera, tick);
  return bump && bump->camera == taken_by && tick >= bump->tick ? bumped_[0] : cameras_[taken_by];
}

void Scene::views(std::uint32_t camera, std::uint64_t tick, std::span<sim::MarkerView> views) const noexcept {
  const sim::SimCamera& from = this->camera(camera, tick);
  const double middle = mid_exposure_s(camera, tick), half = 0.5 * options_.exposure_s;
  std::array<sim::OutlinePoint, kOutlinePoints> outline;
  for (std::uint32_t m = 0; m < options_.markers; ++m) {
    sim::MarkerView& view = views[m];
    view = {};
    double x_low = 1e9, x_high = -1e9, y_low = 1e9, y_high = -1e9;
    bool imaged = true;
    for (const double time : {middle - half, middle + half}) {
      const Eigen::Vector3d centre = from.in_camera(marker(m, time).position_in_world);
      imaged = imaged && from.images(centre, options_.marker_radius_m);
      if (!imaged) break;
      from.outline(centre, options_.marker_radius_m, outline);
      for (const sim::OutlinePoint& p : outline) {
        x_low = std::min(x_low, p.x_px);
        x_high = std::max(x_high, p.x_px);
        y_low = std::min(y_low, p.y_px);
        y_high = std::max(y_high, p.y_px);
      }
      view.distance_m += 0.5 * centre.norm();
    }
    if (!imaged) continue;
    view.imaged = true;
    view.x_px = 0.5 * (x_low + x_high);
    view.y_px = 0.5 * (y_low + y_high);
    view.half_width_px = 0.5 * (x_high - x_low);
    view.half_height_px = 0.5 * (y_high - y_low);
    view.radius_px = std::max(view.half_width_px, view.half_height_px);
  }
}

bool Scene::may_be_hidden(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                          std::span<const sim::MarkerView> views) const noexcept {
  const sim::MarkerView& own = views[marker];
  for (std::uint32_t m = 0; m < options_.markers; ++m) {
    const sim::MarkerView& other = views[m];
    if (m == marker || !other.imaged || other.distance_m >= own.distance_m) continue;
    const double reach = own.radius_px + other.radius_px + 1.0;
    if (std::abs(own.x_px - other.x_px) < reach && std::abs(own.y_px - other.y_px) < reach) return true;
  }
  if (poles_.empty()) return false;
  const Eigen::Vector3d eye = this->camera(camera, tick).position_in_world();
  const Eigen::Vector3d ball = this->marker(marker, mid_exposure_s(camera, tick)).position_in_world;
  // The ray to the middle against a pole that is fatter and higher by the ball and its motion.
  const double grow = options_.marker_radius_m + options_.exposure_s * options_.max_speed_m_s;
  return std::any_of(poles_.begin(), poles_.end(), [&](const sim::Pole& pole) {
    return blocks({pole.x_m, pole.y_m, pole.radius_m + grow, pole.height_m + grow}, eye, ball);
  });
}

Scene::Disc Scene::disc_of(const sim::SimCamera& from, std::uint32_t marker, double time_s) const noexcept {
  // The circle in which the tangent cone touches the ball.
  const Eigen::Vector3d centre = from.in_camera(this->marker(marker, time_s).position_in_world);
  const double distance = centre.norm();
  const double sine = options_.marker_radius_m / distance;
  const double radius = options_.marker_radius_m * std::sqrt(1.0 - sine * sine);
  const Eigen::Vector3d side = centre.unitOrthogonal();
  return {centre * (1.0 - sine * sine), radius * side, radius * (centre / distance).cross(side)};
}

Eigen::Vector3d Scene::disc_point(const Disc& disc, unsigned i, unsigned count) noexcept {
  // Sunflower seeds: even over the disc (Vogel, Math. Biosci. 44, 1979).
  constexpr double kGoldenAngle = 2.399963229728653;
  const double radius = std::sqrt((i + 0.5) / count), angle = i * kGoldenAngle;
  return disc.centre + radius * (std::cos(angle) * disc.right + std::sin(angle) * disc.down);
}

bool Scene::hidden(const sim::SimCamera& from, std::uint32_t marker, double time_s,
                   std::span<const sim::MarkerView> views,
                   const Eigen::Vector3d& point_in_camera) const noexcept {
  const double own_distance = views[marker].distance_m;
  const Eigen::Vector3d ray = point_in_camera.normalized();
  for (std::uint32_t m = 0; m < options_.markers; ++m) {
    const sim::MarkerView& other = views[m];
    if (m == marker || !other.imaged || other.distance_m >= own_distance) continue;
    const double reach = views[marker].radius_px + other.radius_px + 1.0;
    if (std::abs(views[marker].x_px - other.x_px) > reach ||
        std::abs(views[marker].y_px - other.y_px) > reach)
      continue;
    const Eigen::Vector3d centre = from.in_camera(this->marker(m, time_s).position_in_world);
    if (centre.cross(ray).squaredNorm() < options_.marker_radius_m * options_.marker_radius_m) return true;
  }
  if (poles_.empty()) return false;
  const Eigen::Vector3d eye = from.position_in_world();
  const Eigen::Vector3d point = eye + from.camera_from_world_rotation().transpose() * point_in_camera;
  return std::any_of(poles_.begin(), poles_.end(),
                     [&](const sim::Pole& pole) { return blocks(pole, eye, point); });
}

void Scene::truth(std::uint64_t tick, TickTruth& truth) const {
  truth.tick = tick;
  truth.delivered = 0;
  truth.markers.resize(options_.markers);
  const double time_s = mid_exposure_s(tick);
  for (std::uint32_t m = 0; m < options_.markers; ++m) {
    const sim::MarkerState state = marker(m, time_s);
    truth.markers[m] = {state.position_in_world, state.velocity_in_world, 0, 0};
  }
  truth.views.resize(std::size_t{options_.cameras} * options_.markers);
  for (std::uint32_t c = 0; c < options_.cameras; ++c) {
    const std::uint32_t bit = 1u << c;
    if (sim::fate(options_, c, tick) == sim::Fate::Fine) truth.delivered |= bit;
    const auto views = std::span(truth.views).subspan(std::size_t{c} * options_.markers, options_.markers);
    this->views(c, tick, views);
    if (dark(tick)) continue;  // nobody sees anything
    for (std::uint32_t m = 0; m < options_.markers; ++m) {
      const sim::MarkerView& view = views[m];
      if (!view.imaged) continue;
      const double left = view.x_px - view.half_width_px, right = view.x_px + view.half_width_px;
      const double top = view.y_px - view.half_height_px, bottom = view.y_px + view.half_height_px;
      if (left < kFrameMargin_px || right > options_.width_px - 1.0 - kFrameMargin_px) continue;
      if (top < kFrameMargin_px || bottom > options_.height_px - 1.0 - kFrameMargin_px) continue;
      if (may_be_hidden(c, tick, m, views)) {
        unsigned lost = 0;
        sample_disc(c, tick, m, mid_exposure_s(c, tick), views, kDiscSamples,
                    [&](const Eigen::Vector3d&, bool is_hidden) { lost += is_hidden ? 1u : 0u; });
        if (lost > kHiddenShare * kDiscSamples) continue;
      }
      truth.markers[m].visible |= bit;
    }
    if ((truth.delivered & bit) == 0) continue;
    for (std::uint32_t m = 0; m < options_.markers; ++m) {
      if ((truth.markers[m].visible & bit) == 0) continue;
      const sim::MarkerView& view = views[m];
      const auto touches = [&](double x, double y, double radius) {
        return std::hypot(view.x_px - x, view.y_px - y) < view.radius_px + radius + kApart_px;
      };
      bool alone = true;
      // Any other marker that is imaged counts, if only half of it shows.
      for (std::uint32_t n = 0; n < options_.markers && alone; ++n) {
        alone = n == m || !views[n].imaged || !touches(views[n].x_px, views[n].y_px, views[n].radius_px);
      }
      for (const sim::BrightSpot& spot : spots_[behind(c, tick)])
        alone = alone && !touches(spot.x_px, spot.y_px, spot.radius_px);
      if (alone) truth.markers[m].clean |= bit;
    }
  }
}

}  // namespace glint
