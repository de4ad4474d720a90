// SPDX-License-Identifier: MIT
// Markers that meet: nobody's id goes to another marker without a word.
#include "host/track/tracker.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <random>
#include <set>

namespace glint {
namespace {

using Eigen::Vector3d;
using Kind = IdentityEvent::Kind;
using Markers = std::vector<std::optional<Vector3d>>;  // without a place: not seen

constexpr double kDt = 0.011111;
constexpr double kNoise_m = 5e-5;
constexpr unsigned kPatience = 20;  // exposures until a doubt must have an answer

Point measured(const Vector3d& position) {
  Point point;
  point.position_in_world = position;
  point.covariance_m2 = kNoise_m * kNoise_m * Eigen::Matrix3d::Identity();
  point.information_per_m2 = Eigen::Matrix3d::Identity() / (kNoise_m * kNoise_m);
  point.views = 4;
  point.certain = true;
  point.blob_of_camera.fill(-1);
  std::fill_n(point.blob_of_camera.begin(), 4, 0);
  return point;
}

/// Plays markers to a tracker and remembers which id was on which of them.
class Meeting {
 public:
  explicit Meeting(std::uint64_t seed) : random_(seed) {}

  void expose(const Markers& markers) {
    std::vector<std::size_t> order;
    for (std::size_t m = 0; m < markers.size(); ++m)
      if (markers[m]) order.push_back(m);
    if (++exposure_ % 2 == 0) std::reverse(order.begin(), order.end());  // so that nothing hangs on it
    std::vector<Point> points;
    for (const std::size_t m : order)
      points.push_back(
          measured(*markers[m] + kNoise_m * Vector3d(normal_(random_), normal_(random_), normal_(random_))));
    now_ += std::chrono::microseconds(11111);
    tracker_.predict(Timestamp(now_), predictions_);
    tracker_.update(points, tracked, counters);
    note_events();
    for (const TrackedPoint& sample : tracked) note(sample, order);
  }

  std::vector<TrackedPoint> tracked;
  TrackCounters counters;
  std::vector<IdentityEvent> events;  // all so far
  std::set<TrackId> ids;              // published so far
  unsigned silent = 0;        // samples on another marker than the id's last one, neither of them ambiguous
  unsigned broken = 0;        // ids in no doubt on one marker, and then in none on another
  unsigned overdue = 0;       // doubts that got no answer in time, by exposure
  unsigned reused = 0;        // new ids that were not new, and old ones that came again
  unsigned contradicted = 0;  // samples that are in doubt otherwise than the events say

 private:
  struct Last {
    std::size_t marker = 0;
    bool ambiguous = false;
    std::optional<std::size_t> sure{};  // the marker while in no doubt
  };
  struct Open {  // a doubt without an answer
    TrackId a, b;
    unsigned began;
    bool is(TrackId id) const { return a == id || b == id; }
  };

  void note_events() {
    for (const IdentityEvent& event : tracker_.events()) {
      events.push_back(event);
      std::erase_if(open_, [&](const Open& o) { return o.is(event.a) && o.is(event.b); });
      if (event.kind == Kind::Ambiguous) open_.push_back({event.a, event.b, exposure_});
    }
    // All names in the events are those from before.
    for (const IdentityEvent& event : tracker_.events())
      if (event.kind == Kind::Unresolved)
        for (const auto& [from, to] : {std::pair(event.a, event.new_a), {event.b, event.new_b}})
          rename(from, to);
    for (const Open& o : open_) overdue += exposure_ - o.began > kPatience ? 1u : 0u;
  }

  void rename(TrackId from, TrackId to) {
    retired_.insert(from);
    reused += ids.count(to) != 0 ? 1u : 0u;
    for (Open& o : open_) {  // it may be in doubt with others yet
      if (o.a == from) o.a = to;
      if (o.b == from) o.b = to;
    }
  }

  void note(const TrackedPoint& sample, const std::vector<std::size_t>& marker_of) {
    const bool ambiguous = sample.ambiguous_with != TrackId{};
    const bool open = std::any_of(open_.begin(), open_.end(), [&](const Open& o) { return o.is(sample.id); });
    contradicted += ambiguous != open ? 1u : 0u;
    reused += retired_.count(sample.id) != 0 ? 1u : 0u;
    ids.insert(sample.id);
    if (sample.point == kNoPoint) return;
    const std::size_t marker = marker_of[sample.point];
    Last& last = last_.try_emplace(sample.id, Last{marker, ambiguous}).first->second;
    silent += last.marker != marker && !last.ambiguous && !ambiguous ? 1u : 0u;
    broken += !ambiguous && last.sure.value_or(marker) != marker ? 1u : 0u;
    last = {marker, ambiguous, ambiguous ? last.sure : marker};
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  Tracker tracker_{TrackOptions{}};
  std::chrono::microseconds now_{1'000'000};
  unsigned exposure_ = 0;
  std::vector<Prediction> predictions_;
  std::map<TrackId, Last> last_;
  std::vector<Open> open_;
  std::set<TrackId> retired_;
};

/// From 0.3 m away to nothing, as gently as a marker comes to rest; `left` from 60 to 0.
double nearing(int left) { return 0.3 * left * left * (180.0 - 2.0 * left) / 216000.0; }

/// Two markers come to one spot, stand there, and part at right angles to how they came.
void play_standing_together(Meeting& meeting, bool left_is_older) {
  const auto expose = [&](const Vector3d& left, const Vector3d& right) {
    meeting.expose(left_is_older ? Markers{left, right} : Markers{right, left});
  };
  for (int k = 60; k > 0; --k) expose({-nearing(k), 0, 1}, {nearing(k), 0, 1});
  for (int k = 0; k < 15; ++k) expose({0, 0, 1}, {0, 0, 1});
  for (int k = 1; k <= 60; ++k) expose({0, -nearing(k), 1}, {0, nearing(k), 1});
}

TEST(Doubts, MarkersThatPassFarApartAreNeverInDoubt) {
  for (const double apart_m : {0.05, 0.2, 0.5}) {
    Meeting meeting(1);
    for (int k = -60; k <= 60; ++k) {
      const double s = 4.0 * kDt * k;
      meeting.expose({Vector3d(s, 0.5 * apart_m, 1), Vector3d(-s, -0.5 * apart_m, 1)});
    }
    EXPECT_TRUE(meeting.events.empty()) << apart_m;
    EXPECT_EQ(meeting.silent + meeting.broken + meeting.contradicted, 0u);
  }
}

TEST(Doubts, MarkersThatNobodyCanTellApartGetNewIds) {
  for (const bool left_is_older : {true, false})
    for (std::uint64_t seed = 0; seed < 6; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", left is older: " << left_is_older);
      Meeting meeting(seed);
      play_standing_together(meeting, left_is_older);
      EXPECT_EQ(meeting.overdue + meeting.reused, 0u);
      ASSERT_FALSE(meeting.events.empty());
      EXPECT_EQ(meeting.events.front().kind, Kind::Ambiguous);
      const IdentityEvent& end = meeting.events.back();
      ASSERT_EQ(end.kind, Kind::Unresolved);
      ASSERT_EQ(meeting.tracked.size(), 2u);
      for (const TrackedPoint& sample : meeting.tracked)
        EXPECT_TRUE(sample.id == end.new_a || sample.id == end.new_b) << number(sample.id);
    }
}

TEST(Doubts, EventsInTheirOrderSayWhoIsInDoubt) {
  for (std::uint64_t seed = 0; seed < 6; ++seed) {
    Meeting meeting(seed);
    play_standing_together(meeting, true);
    EXPECT_EQ(meeting.contradicted, 0u) << "seed " << seed;
  }
}

TEST(Doubts, FastMarkersThatNearlyTouchAreNotExchangedSilently) {
  std::uint64_t seed = 0, in_doubt = 0;
  for (const double speed_m_s : {2.0, 6.0, 12.0})
    for (const double gap_m : {1e-4, 1e-3, 5e-3})
      for (const double angle : {0.4, 1.6, 3.1})
        for (const double phase : {0.0, 0.37}) {
          Meeting meeting(seed++);
          const Vector3d direction(std::cos(angle), std::sin(angle), 0);
          for (int k = -40; k <= 60; ++k) {
            const double s = speed_m_s * kDt * (k + phase);
            meeting.expose({Vector3d(s, 0, 1), Vector3d(0, 0, 1 + gap_m) + s * direction});
          }
          EXPECT_EQ(meeting.silent + meeting.broken + meeting.overdue + meeting.reused, 0u)
              << speed_m_s << " m/s, gap " << gap_m << " m, angle " << angle << ", phase " << phase;
          in_doubt += meeting.counters.ambiguous;
        }
  EXPECT_GT(in_doubt, 0u);  // else this tests nothing
}

TEST(Doubts, ThreeThatMeetAtOnceAreNotExchangedSilently) {
  for (const bool straight_on : {true, false}) {
    std::uint64_t in_doubt = 0;
    for (std::uint64_t seed = 0; seed < 12; ++seed) {
      SCOPED_TRACE(::testing::Message() << "seed " << seed << ", straight on: " << straight_on);
      std::mt19937_64 random(100 + seed);
      std::normal_distribution<double> normal;
      const auto any = [&] { return Vector3d(normal(random), normal(random), normal(random)).normalized(); };
      std::array<Vector3d, 3> from, to, met;
      for (std::size_t m = 0; m < 3; ++m) {
        const double speed_m_s = std::uniform_real_distribution<double>(1.0, 8.0)(random);
        from[m] = speed_m_s * any();
        to[m] = straight_on ? from[m] : Vector3d(speed_m_s * any());
        met[m] = Vector3d(0, 0, 1) + 2e-4 * any();
      }
      Meeting meeting(seed);
      for (int k = -45; k <= 60; ++k) {
        Markers markers;
        for (std::size_t m = 0; m < 3; ++m) markers.push_back(met[m] + kDt * k * (k < 0 ? from[m] : to[m]));
        meeting.expose(markers);
      }
      EXPECT_EQ(meeting.silent + meeting.overdue + meeting.reused, 0u);
      // Of markers that bounce, even a story 1e10 times likelier is wrong now and then.
      EXPECT_TRUE(!straight_on || meeting.broken == 0u);
      in_doubt += meeting.counters.ambiguous;
    }
    EXPECT_GT(in_doubt, 0u);
  }
}

TEST(Doubts, WhoIsLeftOfAPairInDoubtGetsANewId) {
  unsigned unresolved = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Meeting meeting(seed);
    for (int k = 60; k >= 0; --k) meeting.expose({Vector3d(-nearing(k), 0, 1), Vector3d(nearing(k), 0, 1)});
    Markers left{Vector3d(0, 0, 1), Vector3d(0, 0, 1)};
    left[seed % 2].reset();
    for (int k = 0; k < 30; ++k) meeting.expose(left);
    EXPECT_EQ(meeting.overdue + meeting.reused, 0u);
    ASSERT_EQ(meeting.tracked.size(), 1u);
    ASSERT_FALSE(meeting.events.empty());
    const IdentityEvent& end = meeting.events.back();
    if (end.kind != Kind::Unresolved) continue;  // told apart before the other ended
    ++unresolved;
    EXPECT_NE(end.new_a == TrackId{}, end.new_b == TrackId{});  // one has ended
    EXPECT_EQ(meeting.tracked[0].id, std::max(end.new_a, end.new_b));
  }
  EXPECT_GE(unresolved, 16u);
}

}  // namespace
}  // namespace glint
