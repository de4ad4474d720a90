// SPDX-License-Identifier: MIT
// The order of things in one exposure, and what is put out.
#include "host/body/body_tracker.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "host/base/check.hpp"
#include "host/base/error.hpp"
#include "host/body/acquisition.hpp"
#include "host/body/identity.hpp"
#include "host/body/search.hpp"
#include "host/geometry/rotation.hpp"

namespace glint {
namespace {

constexpr unsigned kTurnedEvery = 6;  // frames between looks at a body whose orientation is in doubt
constexpr unsigned kSureMarkers = 4;  // of a find; with three of more markers it must last some frames

std::vector<BodyModel> checked(std::vector<BodyModel> models) {
  check_bodies(models);
  return models;
}

BodyTrackerOptions checked(const BodyTrackerOptions& options) {
  std::vector<std::string> problems;
  options.check(problems);
  if (!problems.empty()) throw Error(problems.front());
  return options;
}

}  // namespace

void BodyTrackerOptions::check(std::vector<std::string>& problems) const {
  motion.check(problems);
  finder.check(problems);
  if (!(marker_radius_m >= 0.0)) problems.emplace_back("body.marker_radius_m must be >= 0");
  if (!(lost_place_sd_m > 0.0)) problems.emplace_back("body.lost_place_sd_m must be > 0");
  if (!(lost_turn_sd_rad > 0.0)) problems.emplace_back("body.lost_turn_sd_rad must be > 0");
  if (!(ambiguity_log_odds > 0.0)) problems.emplace_back("body.ambiguity_log_odds must be > 0");
  if (!(carried_speed_m_s > 0.0)) problems.emplace_back("body.carried_speed_m_s must be > 0");
}

struct BodyTracker::Impl {
  Impl(std::vector<BodyModel> given, const BodyTrackerOptions& chosen)
      : models(checked(std::move(given))),
        options(checked(chosen)),
        shapes(sort_into_shapes(models)),
        bodies(models.size()),
        fitter(options.marker_radius_m),
        identity(shapes, options),
        search(shapes, options) {
    events.reserve(4 * models.size() + 16);
    held.resize(models.size());
    for (BodyState& body : bodies) body.sample.fill(kNoSample);
  }

  void take(std::uint32_t b);
  void take_back(std::uint32_t b) noexcept;
  bool too_uncertain(const BodyState& body) const noexcept;
  void lose(std::uint32_t b, BodyCounters& counters);
  void show(std::uint32_t b, std::vector<TrackedBody>& out) const;

  const std::vector<BodyModel> models;
  const BodyTrackerOptions options;
  const BodyShapes shapes;
  std::vector<BodyState> bodies;
  SampleIndex index;
  BodyFitter fitter;
  Acquisition acquisition;
  Identity identity;
  BodySearch search;
  std::vector<BodyEvent> events;
  std::vector<std::uint8_t> changed, seeking;
  std::vector<std::array<std::uint32_t, kBodyMarkers>> held;  // samples of those that are looked for again
  bool started = false;
  Timestamp now{};
};

BodyTracker::BodyTracker(std::vector<BodyModel> models, const BodyTrackerOptions& options)
    : impl_(std::make_unique<Impl>(std::move(models), options)) {}
BodyTracker::~BodyTracker() = default;

std::span<const BodyEvent> BodyTracker::events() const noexcept { return impl_->events; }
const std::vector<BodyModel>& BodyTracker::models() const noexcept { return impl_->models; }
void BodyTracker::settle(std::uint32_t body) noexcept { impl_->identity.settle(body); }

void BodyTracker::predict(Timestamp exposed, std::vector<ExpectedMarker>& expected) {
  Impl& t = *impl_;
  const double step_s = t.started ? std::max(0.0, seconds_between(t.now, exposed)) : 0.0;
  t.started = true;
  t.now = std::max(t.now, exposed);
  t.identity.advance(step_s);
  expected.clear();
  for (std::uint32_t b = 0; b < t.bodies.size(); ++b) {
    BodyState& body = t.bodies[b];
    body.since_measured_s += step_s;
    body.fitted = false;
    if (body.moves_on()) body.motion.advance(step_s, t.options.motion);
    if (body.life == BodyLife::Lost) continue;
    const ShapedBody& shaped = t.shapes.bodies[b];
    const Matrix6 covariance = body.motion.pose_covariance();
    for (std::uint32_t m = 0; m < shaped.markers_in_shape.size(); ++m)
      expected.push_back(
          {b, shaped.own_marker[m], body.track[m], body.motion.pose() * shaped.markers_in_shape[m],
           point_covariance(body.motion.pose(), covariance, shaped.markers_in_shape[m], shaped.marker_sd_m)});
  }
}

void BodyTracker::update(std::span<const MarkerSample> samples, std::vector<TrackedBody>& bodies,
                         BodyCounters& counters) {
  Impl& t = *impl_;
  t.events.clear();
  t.index.fill(samples);
  const auto fit = [&](std::uint32_t b) { t.fitter.fit(t.shapes.bodies[b], t.bodies[b], t.index, counters); };
  const auto count = static_cast<std::uint32_t>(t.bodies.size());
  for (std::uint32_t b = 0; b < count; ++b) t.fitter.claim(t.shapes.bodies[b], t.bodies[b], t.index);
  for (std::uint32_t b = 0; b < count; ++b) fit(b);
  t.acquisition.run(t.shapes.bodies, t.bodies, t.index, t.changed, counters);
  for (std::uint32_t b = 0; b < count; ++b)
    if (t.changed[b] != 0) fit(b);
  t.identity.compare(t.bodies, t.events, counters, fit);

  t.seeking.assign(count, 0);
  for (std::uint32_t b = 0; b < count; ++b) {
    BodyState& body = t.bodies[b];
    if (body.jumped) ++counters.jumps;
    if (body.fitted) t.take(b);
    // What no longer knows its markers apart is searched, within its uncertainty and beyond.
    t.seeking[b] = body.life == BodyLife::Lost || !sharp(t.shapes.bodies[b], body) ? 1 : 0;
    // Found by markers that look the same when turned: now and then it is looked for again, with what else
    // has come into sight.
    const Identity::Doubt* doubt = t.identity.doubt_of(b);
    if (doubt != nullptr && doubt->why == BodyDoubt::Symmetric &&
        !t.shapes.symmetric[t.shapes.bodies[b].shape] && body.seen % kTurnedEvery == 0) {
      t.seeking[b] = 1;
      t.search.forget();
    }
    if (t.seeking[b] == 0) continue;
    t.held[b] = body.sample;
    for (const std::uint32_t sample : body.sample)
      if (sample != kNoSample) t.index.use(sample, false);
    body.sample.fill(kNoSample);
    body.markers = 0;
  }
  t.search.run(t.shapes, t.bodies, t.seeking, t.index, t.fitter, t.identity, t.events, counters);
  for (std::uint32_t b = 0; b < count; ++b)
    if (t.seeking[b] != 0 && t.bodies[b].markers == 0) t.take_back(b);

  bodies.clear();
  for (std::uint32_t b = 0; b < count; ++b) {
    BodyState& body = t.bodies[b];
    if (body.life == BodyLife::Lost) continue;
    if (body.markers >= 2) {
      body.last_place = body.fit.world_from_body.translation;
      body.since_measured_s = 0.0;
      body.missed = body.age = 0;
      ++body.seen;
    } else {
      ++body.missed;
      ++body.age;
    }
    const bool unconfirmed = body.life == BodyLife::Tentative && body.markers < 3;
    if (unconfirmed || body.missed > t.options.max_missed_frames || t.too_uncertain(body)) {
      t.lose(b, counters);
      continue;
    }
    const unsigned all = static_cast<unsigned>(t.shapes.bodies[b].markers_in_shape.size());
    if (body.life == BodyLife::Tentative &&
        (body.markers >= std::min(all, kSureMarkers) || body.seen >= t.options.confirm_frames)) {
      body.life = BodyLife::Tracked;
      body.known = true;
      ++counters.found;
      t.events.push_back({BodyEventKind::Found, b, b, BodyDoubt::None});
    }
    if (body.life == BodyLife::Tracked) t.show(b, bodies);
  }
}

void BodyTracker::Impl::take(std::uint32_t b) {
  BodyState& body = bodies[b];
  if (body.jumped)
    body.motion = BodyMotion(body.fit.world_from_body, body.fit.covariance, options.motion);
  else
    body.motion.absorb(body.fit.world_from_body, body.fit.covariance);
}

// It was not found with more markers than it had: what it has measured stands.
void BodyTracker::Impl::take_back(std::uint32_t b) noexcept {
  BodyState& body = bodies[b];
  for (std::size_t m = 0; m < kBodyMarkers; ++m) {
    if (held[b][m] == kNoSample || index.used(held[b][m])) continue;
    body.sample[m] = held[b][m];
    index.use(body.sample[m], true);
    ++body.markers;
  }
}

bool BodyTracker::Impl::too_uncertain(const BodyState& body) const noexcept {
  const Matrix6 c = body.motion.pose_covariance();
  return !(c.bottomRightCorner<3, 3>().trace() < 3.0 * options.lost_place_sd_m * options.lost_place_sd_m) ||
         !(c.topLeftCorner<3, 3>().trace() < options.lost_turn_sd_rad * options.lost_turn_sd_rad);
}

void BodyTracker::Impl::lose(std::uint32_t b, BodyCounters& counters) {
  BodyState& body = bodies[b];
  if (body.life == BodyLife::Tracked) {
    ++counters.lost;
    events.push_back({BodyEventKind::Lost, b, b, BodyDoubt::None});
    identity.lost(b);
  }
  body.life = BodyLife::Lost;
  body.track.fill(TrackId{});
}

void BodyTracker::Impl::show(std::uint32_t b, std::vector<TrackedBody>& out) const {
  const BodyState& body = bodies[b];
  const ShapedBody& shaped = shapes.bodies[b];
  TrackedBody& row = out.emplace_back();
  row.body = b;
  // From the shape's origin to the body's own.
  const Pose& shape = body.motion.pose();
  const Eigen::Vector3d arm = shape.rotation * shaped.shape_from_body.translation;
  row.world_from_body = shape * shaped.shape_from_body;
  Matrix6 by_shape = Matrix6::Identity();
  by_shape.bottomLeftCorner<3, 3>() = -cross_matrix(arm);
  row.covariance.noalias() = by_shape * body.motion.pose_covariance() * by_shape.transpose();
  row.velocity_in_world = body.motion.velocity() + body.motion.angular_velocity().cross(arm);
  row.angular_velocity_in_world = body.motion.angular_velocity();
  row.kind = body.markers >= 2 ? BodyKind::Measured : BodyKind::Predicted;
  row.age_frames = body.age;
  row.markers = body.markers;
  if (body.markers > 0 && body.fitted) {
    row.views = body.fit.views;
    row.rms_px = body.fit.rms_px;
  }
  if (const Identity::Doubt* doubt = identity.doubt_of(b)) {
    row.ambiguous = true;
    row.ambiguous_with = doubt->a == b ? doubt->b : doubt->a;
    row.doubt = doubt->why;
  }
}

}  // namespace glint
