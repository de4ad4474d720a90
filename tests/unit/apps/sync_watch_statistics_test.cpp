// SPDX-License-Identifier: MIT
// Figures of a watch, and what events mean.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/apps/sync_watch.hpp"

namespace glint::apps {
namespace {

using ::testing::HasSubstr;

constexpr std::uint32_t kTickHz = 125'000'000;

sync::TimedTrigger trigger(std::uint64_t sequence, std::uint64_t tick, std::uint16_t run = 1,
                           std::uint8_t flags = 0) {
  sync::TimedTrigger timed;
  timed.trigger.tick = tick;
  timed.trigger.flags = flags;
  timed.sequence = sequence;
  timed.epoch = 100;
  timed.run = run;
  return timed;
}

TEST(WatchStatistics, TheRateIsThatOfTheTicks) {
  WatchStatistics statistics;
  EXPECT_FALSE(statistics.take_window(kTickHz).rate_hz);
  for (std::uint64_t i = 0; i < 90; ++i) statistics.add(trigger(i, 1000 + i * 1388889));
  const auto window = statistics.take_window(kTickHz);
  EXPECT_EQ(window.frames, 90u);
  ASSERT_TRUE(window.rate_hz);
  EXPECT_DOUBLE_EQ(*window.rate_hz, 125e6 / 1388889.0);
}

TEST(WatchStatistics, ASlowRunHasARateFromOneWindowToTheNext) {
  WatchStatistics statistics;
  statistics.add(trigger(0, 0));
  EXPECT_FALSE(statistics.take_window(kTickHz).rate_hz);
  statistics.add(trigger(1, kTickHz * 2));
  EXPECT_DOUBLE_EQ(statistics.take_window(kTickHz).rate_hz.value(), 0.5);
  EXPECT_FALSE(statistics.take_window(kTickHz).rate_hz);
}

TEST(WatchStatistics, AMissingFrameCountsAndDoesNotBendTheRate) {
  WatchStatistics statistics;
  for (std::uint64_t i = 0; i < 10; ++i) {
    if (i != 4 && i != 5) statistics.add(trigger(i, i * 125'000));
  }
  EXPECT_DOUBLE_EQ(statistics.take_window(kTickHz).rate_hz.value(), 1000.0);
  EXPECT_EQ(statistics.frames().missing, 2u);
  EXPECT_EQ(statistics.frames().seen, 8u);
}

TEST(WatchStatistics, ANewRunIsAnotherCount) {
  WatchStatistics statistics;
  for (std::uint64_t i = 0; i < 10; ++i) statistics.add(trigger(i, i * 125'000));
  for (std::uint64_t i = 0; i < 10; ++i) statistics.add(trigger(i, 1'000'000'000 + i * 500'000, 2));
  EXPECT_DOUBLE_EQ(statistics.take_window(kTickHz).rate_hz.value(), 250.0);
  EXPECT_EQ(statistics.frames().missing, 0u);
  EXPECT_EQ(statistics.frames().seen, 20u);
}

TEST(WatchStatistics, FlagsAreCounted) {
  WatchStatistics statistics;
  statistics.add(trigger(0, 0, 1, GLINT_SYNC_TRIGGER_DARK));
  statistics.add(trigger(1, 1, 1, GLINT_SYNC_TRIGGER_LOCKED | GLINT_SYNC_TRIGGER_DARK));
  statistics.add(trigger(2, 2, 1, GLINT_SYNC_TRIGGER_HELD));
  EXPECT_EQ(statistics.frames().dark, 2u);
  EXPECT_EQ(statistics.frames().locked, 1u);
  EXPECT_EQ(statistics.frames().held, 1u);
}

TEST(WatchStatistics, DelaysAreOfTheWindowAndOfAllTheTime) {
  WatchStatistics statistics;
  for (int i = 0; i < 100; ++i) statistics.add_delay(0.5e-3);
  statistics.add_delay(4e-3);
  auto delay = statistics.take_window(kTickHz).delay;
  EXPECT_EQ(delay.count, 101u);
  EXPECT_NEAR(delay.p50_s, 0.5e-3, 0.01e-3);
  EXPECT_DOUBLE_EQ(delay.max_s, 4e-3);
  statistics.add_delay(1e-3);
  delay = statistics.take_window(kTickHz).delay;
  EXPECT_EQ(delay.count, 1u);
  EXPECT_DOUBLE_EQ(delay.max_s, 1e-3);
  EXPECT_EQ(statistics.all_delays().count, 102u);
  EXPECT_DOUBLE_EQ(statistics.all_delays().max_s, 4e-3);
}

WatchEvent told(sync::Event::Kind kind, std::uint32_t sequence, std::uint32_t detail) {
  sync::TimedEvent timed;
  timed.event.kind = kind;
  timed.event.sequence = sequence;
  timed.event.detail = detail;
  timed.run = 3;
  return event_of(timed);
}

TEST(EventOf, SaysWhatHappened) {
  using Kind = sync::Event::Kind;
  EXPECT_THAT(told(Kind::Booted, 0, GLINT_SYNC_RESET_WATCHDOG).text, HasSubstr("by the watchdog"));
  EXPECT_FALSE(told(Kind::Booted, 0, 0).run);
  EXPECT_EQ(told(Kind::Started, 0, 0).text, "run 3 has started");
  const WatchEvent stopped = told(Kind::Stopped, 900, GLINT_SYNC_STOP_BURST_END);
  EXPECT_EQ(stopped.kind, "stopped");
  EXPECT_EQ(stopped.text, "run 3 ended after 900 frames because all pulses are done");
  EXPECT_EQ(stopped.frame, 900u);
  EXPECT_THAT(told(Kind::Stopped, 1, GLINT_SYNC_STOP_FAULT | GLINT_SYNC_FAULT_UNDERRUN << 8).text,
              HasSubstr("1 frame because of a fault: a pulse was not ready in time"));
  EXPECT_EQ(told(Kind::Applied, 17, 0).text, "run 3 has new settings from frame 17 on");
  EXPECT_THAT(told(Kind::Locked, 0, 14200).text, HasSubstr("too high, 14.20 V"));
  EXPECT_THAT(told(Kind::Rearmed, 20, 13700).text, HasSubstr("back at 13.70 V"));
  EXPECT_EQ(told(Kind::Unknown, 0, 0).kind, "unknown");
}

}  // namespace
}  // namespace glint::apps
