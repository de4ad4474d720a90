// SPDX-License-Identifier: MIT
// Two stories of each pair, side by side.
#include "host/track/doubts.hpp"

#include <algorithm>

namespace glint {
namespace {

// What was taken for true and is 10,000 times likelier than the exchange is not in doubt; what was is settled
// at 100,000 times, and an exchange only at 10^10, because to undo one that never was is worse than two new
// ids (decision 0025).
constexpr double kDoubtLog = 9.2, kSettledLog = 11.5, kSwappedLog = 23.0;
constexpr unsigned kPatience = 20;  // exposures; by then both stories' filters have forgotten how it began
constexpr std::size_t kMostPairs = 256;

double likelihood(const Motion& motion, const PositionEvidence* evidence) noexcept {
  return evidence == nullptr ? 0.0 : motion.log_likelihood(*evidence);
}

}  // namespace

Doubts::Doubts() {
  pairs_.reserve(kMostPairs);
  verdicts_.reserve(kMostPairs);
}

void Doubts::advance(double seconds, double acceleration_sd_m_s2) noexcept {
  for (Pair& pair : pairs_) {
    pair.a_swapped.advance(seconds, acceleration_sd_m_s2);
    pair.b_swapped.advance(seconds, acceleration_sd_m_s2);
  }
}

bool Doubts::consider(const Seen& a, const Seen& b) noexcept {
  if (a.evidence == nullptr && b.evidence == nullptr) return false;
  if (pairs_.size() >= kMostPairs) return false;
  if (std::any_of(pairs_.begin(), pairs_.end(), [&](const Pair& pair) {
        return (pair.a == a.id && pair.b == b.id) || (pair.a == b.id && pair.b == a.id);
      }))
    return false;
  // One whose last doubt ends with this exposure may get another id or another motion by that.
  const auto judged = [this](TrackId id) {
    return std::any_of(verdicts_.begin(), verdicts_.end(), [id](const Verdict& v) {
      return (v.a == id || v.b == id) && (v.swapped || !v.decided);
    });
  };
  if (judged(a.id) || judged(b.id)) return false;
  const double ratio = likelihood(*a.motion, a.evidence) + likelihood(*b.motion, b.evidence) -
                       likelihood(*a.motion, b.evidence) - likelihood(*b.motion, a.evidence);
  if (!(ratio < kDoubtLog)) return false;
  Pair& pair = pairs_.emplace_back(
      Pair{a.id, b.id, *a.motion, *b.motion, ratio, a.motion->impacts(), b.motion->impacts(), 0});
  if (b.evidence != nullptr) pair.a_swapped.correct(*b.evidence);
  if (a.evidence != nullptr) pair.b_swapped.correct(*a.evidence);
  return true;
}

bool Doubts::weigh_pair(Pair& pair, const Seen& a, const Seen& b) noexcept {
  pair.log_ratio += likelihood(*a.motion, a.evidence) + likelihood(*b.motion, b.evidence);
  if (b.evidence != nullptr) pair.log_ratio -= pair.a_swapped.correct(*b.evidence);
  if (a.evidence != nullptr) pair.log_ratio -= pair.b_swapped.correct(*a.evidence);
  // Who hits something goes anywhere: of two that met so, no motion tells who is who.
  const bool blow = a.motion->impacts() != pair.a_impacts || b.motion->impacts() != pair.b_impacts ||
                    pair.a_swapped.impacts() != pair.a_impacts || pair.b_swapped.impacts() != pair.b_impacts;
  const bool decided =
      pair.log_ratio > (blow ? kSwappedLog : kSettledLog) || (!blow && pair.log_ratio < -kSwappedLog);
  if (!decided && ++pair.exposures < kPatience) return true;
  verdicts_.push_back({pair.a, pair.b, pair.log_ratio < 0.0, decided, pair.a_swapped, pair.b_swapped});
  return false;
}

// Whoever else was in doubt with one of two that had changed places was compared with the wrong one.
void Doubts::settle() {
  const auto changed_places = [this](const Pair& pair) {
    return std::any_of(verdicts_.begin(), verdicts_.end(), [&pair](const Verdict& v) {
      return v.decided && v.swapped && (v.a == pair.a || v.b == pair.a || v.a == pair.b || v.b == pair.b);
    });
  };
  // Of verdicts that contradict each other none counts.
  for (std::size_t k = 0; k < verdicts_.size(); ++k) {
    Verdict& v = verdicts_[k];
    for (std::size_t other = 0; other < verdicts_.size() && v.swapped; ++other) {
      const Verdict& o = verdicts_[other];
      if (other != k && o.swapped && (o.a == v.a || o.b == v.a || o.a == v.b || o.b == v.b))
        v.decided = verdicts_[other].decided = false;
    }
  }
  const std::size_t verdicts = verdicts_.size();
  for (const Pair& pair : pairs_)
    if (changed_places(pair)) abandon(pair);
  if (verdicts_.size() > verdicts) std::erase_if(pairs_, changed_places);
}

void Doubts::rename(TrackId from, TrackId to) noexcept {
  for (Pair& pair : pairs_) {
    if (pair.a == from) pair.a = to;
    if (pair.b == from) pair.b = to;
  }
}

bool Doubts::abandon(const Pair& pair) {
  verdicts_.push_back({pair.a, pair.b, false, false, pair.a_swapped, pair.b_swapped});
  return false;
}

TrackId Doubts::other_of(TrackId id) const noexcept {
  for (const Pair& pair : pairs_) {
    if (pair.a == id) return pair.b;
    if (pair.b == id) return pair.a;
  }
  return TrackId{};
}

}  // namespace glint
