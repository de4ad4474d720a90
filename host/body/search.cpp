// SPDX-License-Identifier: MIT
// The finder's results, handed out by likelihood.
#include "host/body/search.hpp"

#include <algorithm>
#include <cmath>

#include "host/match/seen_set.hpp"

namespace glint {
namespace {

// The same samples are looked at again only now and then: noise may have spoilt them.
constexpr unsigned kPatience = 8;
constexpr double kWorstSampleSd_m = 0.02;  // what only one camera sees is too vague for distances
// What any body gains from being found, however unlikely there: finds are not refused for their place.
constexpr double kFoundGain = 20.0;
constexpr double kRoom_m3 = 50.0;     // where a lost body may be, if it was carried
constexpr double kCarriedOff = 0.02;  // how often somebody takes it there
constexpr double kPlaceSd_m = 0.05;   // how far a body that nobody touches may seem to have moved

std::vector<WantedShape> wanted_shapes(const BodyShapes& shapes) {
  std::vector<WantedShape> wanted;
  for (const auto& members : shapes.members) {
    const ShapedBody& first = shapes.bodies[members.front()];
    double sd = 0.0;
    for (const std::uint32_t member : members) sd = std::max(sd, shapes.bodies[member].marker_sd_m);
    wanted.push_back({first.markers_in_shape, sd});
  }
  return wanted;
}

}  // namespace

BodySearch::BodySearch(const BodyShapes& shapes, const BodyTrackerOptions& options)
    : options_(options), finder_(wanted_shapes(shapes), options.finder), wanted_(shapes.members.size(), 0) {
  rows_.reserve(shapes.bodies.size());
  before_.reserve(shapes.bodies.size());
}

bool BodySearch::worth_while(const BodyShapes& shapes, std::span<const std::uint8_t> seeking,
                             const SampleIndex& index) {
  std::fill(wanted_.begin(), wanted_.end(), 0u);
  std::uint64_t hash = 0;
  for (std::uint32_t b = 0; b < seeking.size(); ++b) {
    if (seeking[b] == 0) continue;
    ++wanted_[shapes.bodies[b].shape];
    hash += scramble(0x100000000u + b);
  }
  if (hash == 0) return false;
  points_.clear();
  sample_of_point_.clear();
  for (std::uint32_t k = 0; k < index.samples().size(); ++k) {
    const MarkerSample& sample = index.samples()[k];
    if (index.used(k) || !(sample.covariance_m2.trace() < kWorstSampleSd_m * kWorstSampleSd_m)) continue;
    points_.push_back({sample.position_in_world, sample.covariance_m2});
    sample_of_point_.push_back(k);
    hash += scramble(number(sample.track));
  }
  if (points_.size() < options_.finder.min_markers) return false;
  if (hash == looked_at_ && ++waited_ < kPatience) return false;
  looked_at_ = hash;
  waited_ = 0;
  return true;
}

// Log-likelihood of the find's pose for this body against anywhere in the room: where its motion takes it, or
// not far from where it was last, or carried off.
double BodySearch::gain(const BodyState& body, const FoundBody& found) const noexcept {
  const double anywhere = -std::log(kRoom_m3);
  double likelihood = kCarriedOff;
  if (body.known || body.life != BodyLife::Lost) {
    const double sd = kPlaceSd_m + options_.carried_speed_m_s * body.since_measured_s;
    const double chi2 = (found.world_from_shape.translation - body.last_place).squaredNorm() / (sd * sd);
    likelihood += 0.5 * std::exp(-0.5 * chi2 - 3.0 * std::log(sd) - 1.5 * std::log(2.0 * M_PI) - anywhere);
  }
  if (body.moves_on()) {
    const double cost = gaussian_cost(pose_difference(found.world_from_shape, body.motion.pose()),
                                      body.motion.pose_covariance() + found.covariance);
    likelihood +=
        0.5 * std::exp(-0.5 * cost - 3.0 * std::log(2.0 * M_PI) - anywhere + std::log(8 * M_PI * M_PI));
  }
  return kFoundGain + std::log(likelihood);
}

void BodySearch::hand_out(const BodyShapes& shapes, std::span<BodyState> bodies,
                          std::span<const std::uint8_t> seeking) {
  rows_.clear();
  edges_.clear();
  before_.clear();
  for (std::uint32_t b = 0; b < seeking.size(); ++b) {
    if (seeking[b] == 0) continue;
    const auto row = static_cast<std::uint32_t>(rows_.size());
    rows_.push_back(b);
    before_.push_back(bodies[b].motion);
    for (std::uint32_t f = 0; f < found_.size(); ++f)
      if (found_[f].shape == shapes.bodies[b].shape) edges_.push_back({row, f, gain(bodies[b], found_[f])});
  }
  assignment_.solve(rows_.size(), found_.size(), edges_, column_of_row_);
}

void BodySearch::doubt(const BodyShapes& shapes, std::span<const BodyState> bodies, Identity& identity,
                       std::vector<BodyEvent>& events, BodyCounters& counters) {
  for (std::size_t i = 0; i < rows_.size(); ++i)
    for (std::size_t j = 0; j < rows_.size(); ++j) {
      const std::uint32_t a = rows_[i], b = rows_[j];
      const std::uint32_t at_a = column_of_row_[i], at_b = column_of_row_[j];
      if (i == j || shapes.bodies[a].shape != shapes.bodies[b].shape || at_a == kUnassigned) continue;
      if (at_b != kUnassigned && j < i) continue;  // looked at already
      // Names that nobody has borne yet are given, not mistaken.
      if (!bodies[a].known && !bodies[b].known) continue;
      double odds = gain(bodies[a], found_[at_a]) - gain(bodies[b], found_[at_a]);
      if (at_b != kUnassigned) odds += gain(bodies[b], found_[at_b]) - gain(bodies[a], found_[at_b]);
      if (odds >= options_.ambiguity_log_odds) continue;
      const bool moving = at_b != kUnassigned && bodies[a].moves_on() && bodies[b].moves_on();
      if (!moving) {
        identity.doubt_found(a, b, odds, nullptr, nullptr, events, counters);
        continue;
      }
      BodyMotion a_as_b = before_[i], b_as_a = before_[j];
      a_as_b.correct(found_[at_b].world_from_shape, found_[at_b].covariance);
      b_as_a.correct(found_[at_a].world_from_shape, found_[at_a].covariance);
      identity.doubt_found(a, b, odds, &a_as_b, &b_as_a, events, counters);
    }
}

void BodySearch::run(const BodyShapes& shapes, std::span<BodyState> bodies,
                     std::span<const std::uint8_t> seeking, SampleIndex& index, BodyFitter& fitter,
                     Identity& identity, std::vector<BodyEvent>& events, BodyCounters& counters) {
  if (!worth_while(shapes, seeking, index)) return;
  ++counters.searches;
  finder_.find(points_, wanted_, found_, counters.finder);
  if (found_.empty()) return;
  looked_at_ = 0;
  hand_out(shapes, bodies, seeking);
  doubt(shapes, bodies, identity, events, counters);
  for (std::size_t row = 0; row < rows_.size(); ++row) {
    if (column_of_row_[row] == kUnassigned) continue;
    const std::uint32_t b = rows_[row];
    const FoundBody& found = found_[column_of_row_[row]];
    const ShapedBody& shaped = shapes.bodies[b];
    BodyState& body = bodies[b];
    body.track.fill(TrackId{});
    body.sample.fill(kNoSample);
    for (std::size_t m = 0; m < shaped.markers_in_shape.size(); ++m) {
      if (found.point_of_marker[m] == kMarkerNotSeen) continue;
      body.sample[m] = sample_of_point_[found.point_of_marker[m]];
      body.track[m] = index.samples()[body.sample[m]].track;
      index.use(body.sample[m], true);
    }
    body.markers = found.markers;
    if (!fitter.fit_alone(shaped, body, index, found.world_from_shape)) {
      body.fit.world_from_body = found.world_from_shape;
      body.fit.covariance = found.covariance;
      body.fit.views = 0;
      body.fit.rms_px = 0.0;
      body.fitted = true;
    }
    const bool expected =
        body.moves_on() &&
        pose_difference(body.fit.world_from_body, body.motion.pose())
                .dot((body.motion.pose_covariance() + body.fit.covariance)
                         .ldlt()
                         .solve(pose_difference(body.fit.world_from_body, body.motion.pose()))) < kPoseChi2;
    // A motion that led here goes on: it knows the velocity.
    if (expected)
      body.motion.correct(body.fit.world_from_body, body.fit.covariance);
    else
      body.motion = BodyMotion(body.fit.world_from_body, body.fit.covariance, options_.motion);
    if (!expected && body.life == BodyLife::Tracked) {
      ++counters.lost;
      events.push_back({BodyEventKind::Lost, b, b, BodyDoubt::None});
      identity.lost(b);
    }
    if (!expected || body.life == BodyLife::Lost) {
      body.life = BodyLife::Tentative;
      body.seen = 0;
    }
    if (found.relabelled && found.score - found.runner_up < options_.ambiguity_log_odds)
      identity.doubt_turn(b, body.markers, events, counters);
  }
}

}  // namespace glint
