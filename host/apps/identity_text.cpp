// SPDX-License-Identifier: MIT
// Words for doubts and their ends.
#include "host/apps/identity_text.hpp"

namespace glint::apps {
namespace {

constexpr std::chrono::seconds kSecond{1};

std::string name(TrackId id) { return std::to_string(number(id)); }

/// "5 goes on as 31"
std::string outcome(TrackId old_id, TrackId new_id) {
  return name(old_id) + (new_id == TrackId{} ? " has ended" : " goes on as " + name(new_id));
}

std::string count(std::uint64_t value, const char* one, const char* many) {
  return std::to_string(value) + " " + (value == 1 ? one : many);
}

}  // namespace

std::string event_text(TriggerNo tick, const IdentityEvent& event) {
  const std::string both = name(event.a) + " and " + name(event.b);
  const std::string start = "tick " + std::to_string(number(tick)) + ": tracks " + both;
  switch (event.kind) {
    case IdentityEvent::Kind::Kept:
      return start + " can be told apart again: they had not changed places";
    case IdentityEvent::Kind::Swapped:
      return start + " had changed places: " + both + " are right again";
    case IdentityEvent::Kind::Unresolved:
      if (event.new_a != TrackId{} && event.new_b != TrackId{})
        return start + ": nothing tells which is which: they go on as " + name(event.new_a) + " and " +
               name(event.new_b);
      return start + ": nothing tells which is which: " + outcome(event.a, event.new_a) + ", " +
             outcome(event.b, event.new_b);
    case IdentityEvent::Kind::Ambiguous:
      break;
  }
  return start + " cannot be told apart for now";
}

void IdentityLines::take(TriggerNo tick, std::span<const IdentityEvent> events, Timestamp now,
                         std::vector<std::string>& lines) {
  lines.clear();
  if (now >= until_) {
    if (left_out_ > 0) lines.push_back(rest());
    until_ = now + kSecond;
    printed_ = 0;
  }
  for (const IdentityEvent& event : events) {
    if (printed_ == kPerSecond) {
      ++left_out_;
      continue;
    }
    lines.push_back(event_text(tick, event));
    ++printed_;
  }
}

std::string IdentityLines::rest() {
  if (left_out_ == 0) return {};
  const std::string text = "and " + count(left_out_, "further message", "further messages") +
                           " on tracks that are hard to tell apart";
  left_out_ = 0;
  return text;
}

void KindCounts::add(std::span<const TrackedPoint> points) noexcept {
  for (const TrackedPoint& point : points) {
    switch (point.kind) {
      case SampleKind::Measured:
        ++measured;
        break;
      case SampleKind::SingleView:
        ++single_view;
        break;
      case SampleKind::Predicted:
        ++predicted;
        break;
    }
  }
}

std::vector<ReportRow> identity_rows(const KindCounts& points, const TrackCounters& track,
                                     const MatchCounters& match) {
  std::vector<ReportRow> rows;
  rows.push_back({"points by kind",
                  std::to_string(points.measured) + " measured, " + std::to_string(points.single_view) +
                      " single-view, " + std::to_string(points.predicted) + " predicted",
                  "by two or more cameras, by one, by none", false});
  const std::uint64_t answered = track.kept + track.swapped + track.unresolved;
  rows.push_back({"ambiguous pairs of tracks", std::to_string(track.ambiguous),
                  track.ambiguous == 0
                      ? ""
                      : std::to_string(track.kept) + " had kept their places, " +
                            std::to_string(track.swapped) + " had changed them and were put right, " +
                            std::to_string(track.unresolved) + " got new ids, " +
                            std::to_string(track.ambiguous - answered) + " open at the end",
                  false});
  if (match.resolved + match.unresolved > 0) {
    rows.push_back({"blobs looked at by pixels", std::to_string(match.resolved + match.unresolved),
                    "touching, cut off or partly hidden: " + std::to_string(match.resolved) + " placed, " +
                        std::to_string(match.unresolved) + " not explained",
                    false});
  }
  return rows;
}

nlohmann::ordered_json identity_json(const KindCounts& points, const TrackCounters& track,
                                     const MatchCounters& match) {
  return {
      {"points",
       {{"measured", points.measured}, {"single_view", points.single_view}, {"predicted", points.predicted}}},
      {"ambiguous_pairs", track.ambiguous},
      {"kept", track.kept},
      {"swapped", track.swapped},
      {"unresolved", track.unresolved},
      {"blobs_resolved", match.resolved},
      {"blobs_unresolved", match.unresolved}};
}

}  // namespace glint::apps
