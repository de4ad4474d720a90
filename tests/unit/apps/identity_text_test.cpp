// SPDX-License-Identifier: MIT
// What is said of tracks that are hard to tell apart, and how often.
#include "host/apps/identity_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace glint::apps {
namespace {

using Kind = IdentityEvent::Kind;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

IdentityEvent event(Kind kind, std::uint32_t new_a = 0, std::uint32_t new_b = 0) {
  return {kind, TrackId(7), TrackId(9), TrackId(new_a), TrackId(new_b)};
}

std::string said(const IdentityEvent& event) { return event_text(TriggerNo(1234), event); }

Timestamp at_ms(int ms) { return Timestamp(std::chrono::milliseconds(ms)); }

TEST(IdentityText, SaysWhatBecameOfADoubt) {
  EXPECT_EQ(said(event(Kind::Ambiguous)), "tick 1234: tracks 7 and 9 cannot be told apart for now");
  EXPECT_EQ(said(event(Kind::Kept)),
            "tick 1234: tracks 7 and 9 can be told apart again: they had not changed places");
  EXPECT_EQ(said(event(Kind::Swapped)),
            "tick 1234: tracks 7 and 9 had changed places: 7 and 9 are right again");
  EXPECT_EQ(said(event(Kind::Unresolved, 31, 32)),
            "tick 1234: tracks 7 and 9: nothing tells which is which: they go on as 31 and 32");
  EXPECT_EQ(said(event(Kind::Unresolved, 31, 0)),
            "tick 1234: tracks 7 and 9: nothing tells which is which: 7 goes on as 31, 9 has ended");
  EXPECT_EQ(said(event(Kind::Unresolved)),
            "tick 1234: tracks 7 and 9: nothing tells which is which: 7 has ended, 9 has ended");
}

TEST(IdentityText, PrintsSoManyLinesASecondAndCountsTheRest) {
  IdentityLines log;
  std::vector<std::string> lines;
  const std::vector<IdentityEvent> few(15, event(Kind::Ambiguous));
  log.take(TriggerNo(1), few, at_ms(10'000), lines);
  EXPECT_EQ(lines.size(), 15u);
  log.take(TriggerNo(2), few, at_ms(10'900), lines);
  EXPECT_EQ(lines.size(), IdentityLines::kPerSecond - 15);
  log.take(TriggerNo(3), few, at_ms(10'999), lines);
  EXPECT_THAT(lines, IsEmpty());
  log.take(TriggerNo(4), {}, at_ms(11'000), lines);
  EXPECT_THAT(lines, ElementsAre("and 25 further messages on tracks that are hard to tell apart"));
  log.take(TriggerNo(5), few, at_ms(11'100), lines);
  EXPECT_EQ(lines.size(), 15u) << "a new second";
  EXPECT_EQ(log.rest(), "");
}

TEST(IdentityText, TellsOfTheRestAtTheEnd) {
  IdentityLines log;
  std::vector<std::string> lines;
  log.take(TriggerNo(1), std::vector(IdentityLines::kPerSecond + 1, event(Kind::Kept)), at_ms(5), lines);
  EXPECT_EQ(lines.size(), IdentityLines::kPerSecond);
  EXPECT_EQ(log.rest(), "and 1 further message on tracks that are hard to tell apart");
  EXPECT_EQ(log.rest(), "") << "told once";
}

TEST(IdentityText, RowsAndJson) {
  std::vector<TrackedPoint> points(6);
  points[1].kind = points[2].kind = SampleKind::SingleView;
  points[3].kind = points[4].kind = points[5].kind = SampleKind::Predicted;
  KindCounts kinds;
  kinds.add(points);
  TrackCounters track;
  MatchCounters match;
  std::vector<ReportRow> rows = identity_rows(kinds, track, match);
  ASSERT_EQ(rows.size(), 2u) << "no pixels were looked at";
  EXPECT_EQ(rows[0].value, "1 measured, 2 single-view, 3 predicted");
  EXPECT_EQ(rows[1].value, "0");
  EXPECT_EQ(rows[1].note, "");

  track.ambiguous = 10;
  track.kept = 5;
  track.swapped = 2;
  track.unresolved = 1;
  match.resolved = 40;
  match.unresolved = 3;
  rows = identity_rows(kinds, track, match);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[1].value, "10");
  EXPECT_EQ(
      rows[1].note,
      "5 had kept their places, 2 had changed them and were put right, 1 got new ids, 2 open at the end");
  EXPECT_EQ(rows[2].value, "43");
  EXPECT_EQ(rows[2].note, "touching, cut off or partly hidden: 40 placed, 3 not explained");

  const nlohmann::ordered_json json = identity_json(kinds, track, match);
  EXPECT_EQ(json["points"]["single_view"], 2);
  EXPECT_EQ(json["ambiguous_pairs"], 10);
  EXPECT_EQ(json["swapped"], 2);
  EXPECT_EQ(json["blobs_resolved"], 40);
}

}  // namespace
}  // namespace glint::apps
