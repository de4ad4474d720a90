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
  const sim::Volume volume;
  movement_ = sim::make_movement(options, volume);
  if (options.person) person_.emplace(options);
  for (std::uint32_t c = 0; c < options.cameras; ++c) {
    cameras_.emplace_back(calibration_.cameras[c]);
    spots_.push_back(place_spots(options, c));
    glows_.push_back(place_glow(options, c));
  }
  if (options.faults.bump) {
    bumped_.push_back(cameras_[options.faults.bump->camera].turned(options.faults.bump->angle_rad));
  }
  poles_ = place_poles(options, volume);
}

double Scene::mid_exposure_s(std::uint32_t camera, std::uint64_t tick) const noexcept {
  const auto& delay = options_.faults.delay;
  const bool delayed = delay && delay->camera == camera && tick >= delay->tick;
  return mid_exposure_s(tick) + (delayed ? delay->delay_s : 0.0);
}

std::vector<Eigen::Vector3d> Scene::body_markers(std::uint32_t body) const {
  const auto markers = movement_->body_markers(body);
  return {markers.begin(), markers.end()};
}

std::optional<std::uint32_t> Scene::body_of(std::uint32_t marker) const noexcept {
  if (bodies() == 0) return std::nullopt;
  return marker / options_.bodies.markers;
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
    if (sim::missing(options_, camera, tick, m)) continue;
    double x_low = 1e9, x_high = -1e9, y_low = 1e9, y_high = -1e9;
    bool imaged = true;
    for (const double time : {middle - half, middle + half}) {
      const Eigen::Vector3d centre = from.in_camera(position(m, time));
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

void Scene::truth(std::uint64_t tick, TickTruth& truth) const {
  truth.tick = tick;
  truth.delivered = 0;
  truth.markers.resize(options_.markers);
  const double time_s = mid_exposure_s(tick);
  for (std::uint32_t m = 0; m < options_.markers; ++m) {
    const sim::MarkerState state = marker(m, time_s);
    truth.markers[m] = {state.position_in_world, state.velocity_in_world, 0, 0};
  }
  truth.world_from_body.resize(bodies());
  for (std::uint32_t b = 0; b < bodies(); ++b)
    truth.world_from_body[b] = movement_->world_from_body(b, time_s);
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
      MarkerTruth& marker = truth.markers[m];
      if ((marker.visible & bit) != 0 && stands_alone(c, tick, m, views)) marker.clean |= bit;
    }
  }
}

bool Scene::stands_alone(std::uint32_t camera, std::uint64_t tick, std::uint32_t marker,
                         std::span<const sim::MarkerView> views) const noexcept {
  const sim::MarkerView& view = views[marker];
  const auto touches = [&](double x, double y, double radius) {
    return std::hypot(view.x_px - x, view.y_px - y) < view.radius_px + radius + kApart_px;
  };
  // Any other marker that is imaged counts, if only half of it shows.
  for (std::uint32_t n = 0; n < options_.markers; ++n) {
    if (n != marker && views[n].imaged && touches(views[n].x_px, views[n].y_px, views[n].radius_px))
      return false;
  }
  for (const sim::BrightSpot& spot : spots_[behind(camera, tick)]) {
    if (touches(spot.x_px, spot.y_px, spot.radius_px)) return false;
  }
  sim::Blinks blinks(options_, camera, tick);
  for (std::uint32_t i = 0; i < blinks.count(); ++i) {
    const sim::Blink blink = blinks.next();
    const double half_px = 0.5 * blink.size_px;
    if (touches(blink.x_px + half_px - 0.5, blink.y_px + half_px - 0.5, half_px)) return false;
  }
  return true;
}

}  // namespace glint
