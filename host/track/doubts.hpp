// SPDX-License-Identifier: MIT
// Pairs of tracks of which nobody can say, for now, which is which.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "host/base/ids.hpp"
#include "host/track/motion.hpp"

namespace glint {

/// What became of the question which of two tracks is which.
struct IdentityEvent {
  enum class Kind : std::uint8_t {
    Ambiguous,   ///< from now on the two may have changed places
    Kept,        ///< they had not
    Swapped,     ///< they had: ids are right again from now on
    Unresolved,  ///< nothing tells: they go on under new ids, since an old one may be wrong
  };
  Kind kind = Kind::Ambiguous;
  TrackId a{}, b{};
  TrackId new_a{}, new_b{};  ///< Unresolved only; 0: that track had ended
};

/// Follows both stories of each pair, "each went its way" and "they changed places", by motion models of
/// their own, until one is far likelier. Thread-bound; a track may be in doubt with
/// several others. No allocation; at most 256 pairs.
class Doubts {
 public:
  struct Seen {
    TrackId id{};
    const Motion* motion = nullptr;              ///< predicted, not yet corrected; borrowed for the call
    const PositionEvidence* evidence = nullptr;  ///< of this exposure; nullptr: not seen
  };
  struct Verdict {
    TrackId a{}, b{};
    bool swapped = false, decided = false;
    Motion a_motion, b_motion;  ///< if swapped: what the two then are, this exposure included
  };

  Doubts();
  void advance(double seconds, double acceleration_sd_m_s2) noexcept;

  /// Two tracks that are near each other: is there now a doubt about them that was not there before?
  bool consider(const Seen& a, const Seen& b) noexcept;
  /// The next exposure of all pairs in doubt. `find` gives a Seen for an id, or nothing if the track has
  /// ended.
  template <typename Find>
  void weigh(Find&& find) {
    verdicts_.clear();
    std::size_t kept = 0;
    for (Pair& pair : pairs_) {
      const std::optional<Seen> a = find(pair.a), b = find(pair.b);
      if (!(a && b ? weigh_pair(pair, *a, *b) : abandon(pair))) continue;
      if (&pair != &pairs_[kept]) pairs_[kept] = pair;
      ++kept;
    }
    pairs_.erase(pairs_.begin() + static_cast<std::ptrdiff_t>(kept), pairs_.end());
    settle();
  }
  /// A track goes on under another id.
  void rename(TrackId from, TrackId to) noexcept;
  /// Of the last weigh().
  std::span<const Verdict> verdicts() const noexcept { return verdicts_; }
  /// The track that it may have changed places with; 0: none.
  TrackId other_of(TrackId id) const noexcept;

 private:
  struct Pair {
    TrackId a, b;
    Motion a_swapped, b_swapped;    ///< the history of one with the sightings of the other since
    double log_ratio;               ///< kept over swapped
    unsigned a_impacts, b_impacts;  ///< before the doubt
    unsigned exposures;
  };
  bool weigh_pair(Pair& pair, const Seen& a, const Seen& b) noexcept;  // whether it goes on
  bool abandon(const Pair& pair);
  void settle();

  std::vector<Pair> pairs_;
  std::vector<Verdict> verdicts_;
};

}  // namespace glint
