// SPDX-License-Identifier: MIT
// Doubts about which track is which, in words: while a run goes on, and what they came to.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/base/ids.hpp"
#include "host/match/matcher.hpp"
#include "host/output/report.hpp"
#include "host/track/tracker.hpp"

namespace glint::apps {

/// "tick 1234: tracks 7 and 9 cannot be told apart for now"
std::string event_text(TriggerNo tick, const IdentityEvent& event);

/// Keeps messages readable where many markers touch: so many lines a second, and of the rest the number.
class IdentityLines {
 public:
  static constexpr unsigned kPerSecond = 20;

  /// Replaces `lines` with those to print at time `now`, which does not go back. Call for every tick, also
  /// for one without events: the number of those left out is told when their second is over.
  void take(TriggerNo tick, std::span<const IdentityEvent> events, Timestamp now,
            std::vector<std::string>& lines);
  /// The end: what was left out and not told yet; "" for nothing.
  std::string rest();

 private:
  Timestamp until_{};  // end of the second that is being counted
  unsigned printed_ = 0;
  std::uint64_t left_out_ = 0;
};

/// Points that were put out, by what they rest on.
struct KindCounts {
  std::uint64_t measured = 0, single_view = 0, predicted = 0;

  void add(std::span<const TrackedPoint> points) noexcept;
};

/// Rows on kinds of points, on pairs in doubt, and on blobs looked at by their pixels, if there were any.
std::vector<ReportRow> identity_rows(const KindCounts& points, const TrackCounters& track,
                                     const MatchCounters& match);
nlohmann::ordered_json identity_json(const KindCounts& points, const TrackCounters& track,
                                     const MatchCounters& match);

}  // namespace glint::apps
