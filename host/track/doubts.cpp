// SPDX-License-Identifier: MIT
// Two stories of each pair, side by side.
#include "host/track/doubts.hpp"

#include <algorithm>

namespace glint {
namespace {

// A story that is 150 times likelier than the other is not in doubt; one that was in doubt is settled at
// 1,000 times.
constexpr double kDoubtLog = 9.2, kSettledLog = 11.5;
constexpr unsigned kPatience = 20;  // exposures; by then both stories' filters have forgotten how it began
constexpr std::size_t kReserved = 64;

double likelihood(const Motion& motion, const PositionEvidence* evidence) noexcept {
  return evidence == nullptr ? 0.0 : motion.log_likelihood(*evidence);
}

}  // namespace

Doubts::Doubts() {
  pairs_.reserve(kReserved);
  verdicts_.reserve(kReserved);
}

void Doubts::advance(double seconds, double acceleration_sd_m_s2) noexcept {
  for (Pair& pair : pairs_) {
    pair.a_swapped.advance(seconds, acceleration_sd_m_s2);
    pair.b_swapped.advance(seconds, acceleration_sd_m_s2);
  }
}

bool Doubts::consider(const Seen& a, const Seen& b) noexcept {
  if (a.evidence == nullptr && b.evidence == nullptr) return false;
  if (pairs_.size() >= kReserved || other_of(a.id) != TrackId{} || other_of(b.id) != TrackId{}) return false;
  // One whose last doubt ends with this exposure may get another id or another motion by that.
  const auto judged = [this](TrackId id) {
    return std::any_of(verdicts_.begin(), verdicts_.end(),
                       [id](const Verdict& v) { return v.a == id || v.b == id; });
  };
  if (judged(a.id) || judged(b.id)) return false;
  const double ratio = likelihood(*a.motion, a.evidence) + likelihood(*b.motion, b.evidence) -
                       likelihood(*a.motion, b.evidence) - likelihood(*b.motion, a.evidence);
  if (!(ratio < kDoubtLog)) return false;
  Pair& pair = pairs_.emplace_back(Pair{a.id, b.id, *a.motion, *b.motion, ratio, 0});
  if (b.evidence != nullptr) pair.a_swapped.correct(*b.evidence);
  if (a.evidence != nullptr) pair.b_swapped.correct(*a.evidence);
  return true;
}

bool Doubts::weigh_pair(Pair& pair, const Seen& a, const Seen& b) noexcept {
  pair.log_ratio += likelihood(*a.motion, a.evidence) + likelihood(*b.motion, b.evidence);
  if (b.evidence != nullptr) pair.log_ratio -= pair.a_swapped.correct(*b.evidence);
  if (a.evidence != nullptr) pair.log_ratio -= pair.b_swapped.correct(*a.evidence);
  const bool decided = std::abs(pair.log_ratio) > kSettledLog;
  if (!decided && ++pair.exposures < kPatience) return true;
  verdicts_.push_back({pair.a, pair.b, pair.log_ratio < 0.0, decided, pair.a_swapped, pair.b_swapped});
  return false;
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
