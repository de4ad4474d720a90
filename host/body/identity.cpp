// SPDX-License-Identifier: MIT
// Odds between bodies of one shape.
#include "host/body/identity.hpp"

#include <algorithm>
#include <cmath>

namespace glint {
namespace {

// By then both motions have learnt the same from the same measurements, and their odds no longer change.
constexpr unsigned kWeighedFrames = 90;
constexpr double kFarSigmas = 10.0;

double cost_of(const BodyState& body) noexcept {
  return gaussian_cost(pose_difference(body.fit.world_from_body, body.motion.pose()),
                       body.motion.pose_covariance() + body.fit.covariance);
}

double place_sd(const Matrix6& covariance) noexcept {
  return std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
}

}  // namespace

Identity::Identity(const BodyShapes& shapes, const BodyTrackerOptions& options) : options_(options) {
  for (const auto& members : shapes.members)
    for (std::size_t i = 0; i < members.size(); ++i)
      for (std::size_t j = i + 1; j < members.size(); ++j) pairs_.emplace_back(members[i], members[j]);
  doubts_.reserve(pairs_.size() + shapes.bodies.size());
}

void Identity::advance(double seconds) noexcept {
  for (Doubt& doubt : doubts_)
    if (doubt.weighed) doubt.swap.advance(seconds, options_.motion);
}

bool Identity::near(const BodyState& a, const BodyState& b) noexcept {
  if (a.jumped || b.jumped) return true;
  const double distance = (a.motion.pose().translation - b.motion.pose().translation).norm();
  return distance <
         kFarSigmas * (place_sd(a.motion.pose_covariance()) + place_sd(b.motion.pose_covariance()));
}

double Identity::odds_of(const BodyState& a, const BodyState& b) noexcept {
  return log_odds_of_no_swap(a.motion, a.fit.world_from_body, a.fit.covariance, b.motion,
                             b.fit.world_from_body, b.fit.covariance);
}

void Identity::exchange_measurements(BodyState& a, BodyState& b) noexcept {
  std::swap(a.track, b.track);
  std::swap(a.sample, b.sample);
  std::swap(a.fit, b.fit);
  std::swap(a.jumped, b.jumped);
  std::swap(a.markers, b.markers);
}

const Identity::Doubt* Identity::doubt_between(std::uint32_t a, std::uint32_t b) const noexcept {
  const auto found = std::find_if(doubts_.begin(), doubts_.end(), [&](const Doubt& d) {
    return (d.a == a && d.b == b) || (d.a == b && d.b == a);
  });
  return found == doubts_.end() ? nullptr : &*found;
}

const Identity::Doubt* Identity::doubt_of(std::uint32_t body) const noexcept {
  const auto found = std::find_if(doubts_.begin(), doubts_.end(),
                                  [body](const Doubt& d) { return d.a == body || d.b == body; });
  return found == doubts_.end() ? nullptr : &*found;
}

void Identity::tell(const Doubt& doubt, BodyEventKind kind, std::vector<BodyEvent>& events) const {
  events.push_back({kind, doubt.a, doubt.b, doubt.why});
  if (doubt.b != doubt.a) events.push_back({kind, doubt.b, doubt.a, doubt.why});
}

void Identity::doubt_crossing(std::uint32_t a, std::uint32_t b, std::span<const BodyState> bodies,
                              std::vector<BodyEvent>& events, BodyCounters& counters) {
  Doubt& doubt = doubts_.emplace_back();
  doubt.a = a;
  doubt.b = b;
  doubt.why = BodyDoubt::Crossing;
  doubt.weighed = true;
  doubt.swap = SwapHypothesis(bodies[a].motion, bodies[b].motion, 0.0);  // weighed at once
  ++counters.ambiguous;
  tell(doubt, BodyEventKind::Ambiguous, events);
}

void Identity::doubt_found(std::uint32_t a, std::uint32_t b, double log_odds, const BodyMotion* a_as_b,
                           const BodyMotion* b_as_a, std::vector<BodyEvent>& events, BodyCounters& counters) {
  if (doubt_between(a, b) != nullptr) return;
  Doubt& doubt = doubts_.emplace_back();
  doubt.a = a;
  doubt.b = b;
  doubt.why = BodyDoubt::FoundAgain;
  doubt.weighed = a_as_b != nullptr && b_as_a != nullptr;
  if (doubt.weighed) doubt.swap = SwapHypothesis(*a_as_b, *b_as_a, log_odds);
  ++counters.ambiguous;
  tell(doubt, BodyEventKind::Ambiguous, events);
}

void Identity::doubt_turn(std::uint32_t body, unsigned markers, std::vector<BodyEvent>& events,
                          BodyCounters& counters) {
  if (doubt_between(body, body) != nullptr) return;
  Doubt& doubt = doubts_.emplace_back();
  doubt.a = doubt.b = body;
  doubt.why = BodyDoubt::Symmetric;
  doubt.markers = markers;
  ++counters.ambiguous;
  tell(doubt, BodyEventKind::Ambiguous, events);
}

void Identity::settle(std::uint32_t body) noexcept {
  std::erase_if(doubts_, [body](const Doubt& d) { return d.a == body || d.b == body; });
}

void Identity::lost(std::uint32_t body) noexcept {
  for (Doubt& d : doubts_)
    if (d.a == body || d.b == body) d.weighed = false;
  std::erase_if(doubts_, [body](const Doubt& d) { return d.a == body && d.b == body; });
}

void Identity::weigh(std::span<BodyState> bodies, std::vector<BodyEvent>& events, BodyCounters& counters) {
  for (std::size_t k = 0; k < doubts_.size();) {
    Doubt& doubt = doubts_[k];
    BodyState &a = bodies[doubt.a], &b = bodies[doubt.b];
    // A marker more, in its place: turned the other way it would not be there.
    if (doubt.a == doubt.b && a.fitted && a.markers > doubt.markers) {
      const Doubt decided = doubt;
      doubts_.erase(doubts_.begin() + static_cast<std::ptrdiff_t>(k));
      ++counters.kept;
      tell(decided, BodyEventKind::Kept, events);
      continue;
    }
    if (!doubt.weighed || !a.fitted || !b.fitted) {
      ++k;
      continue;
    }
    doubt.swap.weigh(a.fit.world_from_body, a.fit.covariance, cost_of(a), b.fit.world_from_body,
                     b.fit.covariance, cost_of(b));
    if (++doubt.age >= kWeighedFrames) doubt.weighed = false;
    const double odds = doubt.swap.log_odds();
    if (std::abs(odds) < options_.ambiguity_log_odds) {
      ++k;
      continue;
    }
    const Doubt decided = doubt;
    doubts_.erase(doubts_.begin() + static_cast<std::ptrdiff_t>(k));
    if (odds > 0.0) {
      ++counters.kept;
      tell(decided, BodyEventKind::Kept, events);
      continue;
    }
    std::swap(a, b);
    // What was doubtful about the one is now doubtful about the other.
    for (Doubt& other : doubts_)
      for (std::uint32_t* body : {&other.a, &other.b}) {
        if (*body == decided.a)
          *body = decided.b;
        else if (*body == decided.b)
          *body = decided.a;
      }
    ++counters.exchanged;
    tell(decided, BodyEventKind::Exchanged, events);
  }
}

}  // namespace glint
