// SPDX-License-Identifier: MIT
// A board that comes and goes, loses reports and forgets: its own logic, in real time.
#include "usb-sync/board_link.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>
#include <thread>

#include "tests/unit/usb-sync/plugged_board.hpp"

namespace glint::sync {
namespace {

using namespace std::chrono_literals;

BoardPlan plan_of(Seconds period) {
  BoardPlan plan;
  plan.period = period;
  plan.outputs[0] = {.enabled = true, .width = 100us};
  return plan;
}

class BoardLinkTest : public ::testing::Test {
 protected:
  BoardLinkTest() {
    options_.clock.least_request = options_.clock.least_answer = 0s;  // the cable is memory
    options_.reopen_period = 5ms;
    options_.status_period = 50ms;
  }

  /// All that comes until `done` says so of one of them; throws after 5 s.
  template <class Done>
  std::vector<LinkUpdate> until(BoardLink& link, Done&& done) {
    std::vector<LinkUpdate> updates;
    const HostTime deadline = HostClock::now() + 5s;
    while (HostClock::now() < deadline) {
      updates.push_back(link.next(20ms));
      if (done(updates.back())) return updates;
      if (std::holds_alternative<NothingYet>(updates.back())) updates.pop_back();
    }
    throw std::runtime_error("what was waited for did not come");
  }
  template <class Wanted>
  std::vector<LinkUpdate> until(BoardLink& link) {
    return until(link, [](const LinkUpdate& update) { return std::holds_alternative<Wanted>(update); });
  }
  std::vector<LinkUpdate> until_trigger(BoardLink& link, std::uint64_t sequence) {
    return until(link, [=](const LinkUpdate& update) {
      const auto* trigger = std::get_if<TimedTrigger>(&update);
      return trigger != nullptr && trigger->sequence >= sequence;
    });
  }

  static std::vector<std::uint64_t> sequences(const std::vector<LinkUpdate>& updates) {
    std::vector<std::uint64_t> numbers;
    for (const LinkUpdate& update : updates) {
      if (const auto* trigger = std::get_if<TimedTrigger>(&update)) numbers.push_back(trigger->sequence);
    }
    return numbers;
  }
  static void expect_consecutive(const std::vector<std::uint64_t>& numbers) {
    for (std::size_t i = 1; i < numbers.size(); ++i) ASSERT_EQ(numbers[i], numbers[i - 1] + 1);
  }

  PluggedBoard plugged_;
  PluggedBus bus_{{&plugged_}};
  LinkOptions options_;
};

TEST_F(BoardLinkTest, EveryTriggerComesOnceInOrderAndInHostTime) {
  BoardLink link("", options_, bus_);
  const HostTime before = HostClock::now();
  link.board()->start(plan_of(1ms));
  const auto updates = until_trigger(link, 500);
  const auto numbers = sequences(updates);
  ASSERT_GE(numbers.size(), 501u);
  EXPECT_EQ(numbers.front(), 0u);
  expect_consecutive(numbers);
  HostTime last = before;
  for (const LinkUpdate& update : updates) {
    const auto* trigger = std::get_if<TimedTrigger>(&update);
    if (trigger == nullptr) continue;
    EXPECT_GE(trigger->begin.time + trigger->begin.half_width, last);
    EXPECT_LE(trigger->begin.time - trigger->begin.half_width, HostClock::now());
    EXPECT_LE(trigger->begin.half_width, 5ms);
    last = trigger->begin.time;
  }
  EXPECT_EQ(link.counters().lost, 0u);
  EXPECT_EQ(link.counters().flawed, 0u);
  link.board()->stop();
}

TEST_F(BoardLinkTest, EventsKeepTheirPlaceBetweenTriggers) {
  BoardLink link("", options_, bus_);
  BoardPlan plan = plan_of(2ms);
  plan.pulses = 5;
  link.board()->start(plan);
  const auto updates = until(link, [](const LinkUpdate& update) {
    const auto* event = std::get_if<TimedEvent>(&update);
    return event != nullptr && event->event.kind == Event::Kind::Stopped;
  });
  ASSERT_EQ(updates.size(), 7u);
  EXPECT_EQ(std::get<TimedEvent>(updates.front()).event.kind, Event::Kind::Started);
  EXPECT_TRUE(std::get<TimedTrigger>(updates[5]).trigger.last());
  const auto& stopped = std::get<TimedEvent>(updates.back());
  EXPECT_EQ(stopped.event.stop_reason(), std::uint32_t{GLINT_SYNC_STOP_BURST_END});
  EXPECT_EQ(stopped.event.sequence, 5u);
}

TEST_F(BoardLinkTest, WaitsNoLongerThanItMay) {
  BoardLink link("", options_, bus_);
  const HostTime before = HostClock::now();
  EXPECT_TRUE(std::holds_alternative<NothingYet>(link.next(30ms)));
  EXPECT_GE(HostClock::now() - before, 30ms);
  EXPECT_LT(HostClock::now() - before, 200ms);
  plugged_.unplug();
  until<LinkGone>(link);
  const HostTime gone = HostClock::now();
  EXPECT_TRUE(std::holds_alternative<NothingYet>(link.next(30ms)));
  EXPECT_LT(HostClock::now() - gone, 200ms);
  EXPECT_TRUE(std::holds_alternative<NothingYet>(link.next(0ms)));
}

TEST_F(BoardLinkTest, CallsWithoutAnyTimeToWaitKeepUp) {
  BoardLink link("", options_, bus_);
  link.board()->start(plan_of(5ms));
  std::vector<LinkUpdate> updates;
  const HostTime deadline = HostClock::now() + 1s;
  while (HostClock::now() < deadline) {
    while (!std::holds_alternative<NothingYet>(updates.emplace_back(link.next(0ms)))) {
    }
    ASSERT_EQ(plugged_.queued(), 0u);
    std::this_thread::sleep_for(10ms);
  }
  const auto numbers = sequences(updates);
  expect_consecutive(numbers);
  EXPECT_GE(numbers.size(), 150u);
  EXPECT_EQ(link.counters().lost, 0u);
  link.board()->stop();
}

TEST_F(BoardLinkTest, ReportsThatTheKernelDroppedAreFetched) {
  BoardLink link("", options_, bus_);
  link.board()->start(plan_of(1ms));
  until_trigger(link, 20);
  plugged_.lose_next = 7;
  const auto first = until_trigger(link, 60);
  expect_consecutive(sequences(first));
  std::this_thread::sleep_for(300ms);  // the kernel's queue of 63 overflows
  const auto second = until_trigger(link, 600);
  expect_consecutive(sequences(second));
  EXPECT_EQ(sequences(second).front(), sequences(first).back() + 1);
  EXPECT_GE(link.counters().fetched, 7u);
  EXPECT_EQ(link.counters().lost, 0u);
  link.board()->stop();
}

TEST_F(BoardLinkTest, LossAtTheEndOfARunIsFoundAsWell) {
  BoardLink link("", options_, bus_);
  BoardPlan plan = plan_of(2ms);
  plan.pulses = 10;
  link.board()->start(plan);
  until_trigger(link, 4);
  plugged_.lose_next = 1000;
  const auto updates = until(link, [](const LinkUpdate& update) {
    const auto* event = std::get_if<TimedEvent>(&update);
    return event != nullptr && event->event.kind == Event::Kind::Stopped;
  });
  EXPECT_EQ(sequences(updates).back(), 9u);
  EXPECT_EQ(link.counters().lost, 0u);
}

TEST_F(BoardLinkTest, WhatCannotBeFetchedIsCountedAndTold) {
  BoardLink link("", options_, bus_);
  link.board()->start(plan_of(2ms));
  const auto before = sequences(until_trigger(link, 10));
  plugged_.forgets = true;
  plugged_.lose_next = 3;
  const auto updates = until<ReportsLost>(link);
  EXPECT_EQ(std::get<ReportsLost>(updates.back()).count, 3u);
  EXPECT_EQ(link.counters().lost, 3u);
  const auto after = until<TimedTrigger>(link);
  EXPECT_EQ(sequences(after).front(), before.back() + sequences(updates).size() + 4);
  link.board()->stop();
}

TEST_F(BoardLinkTest, UnpluggedAndPluggedInAgainItGoesOnInANewEpoch) {
  BoardLink link("", options_, bus_);
  link.board()->start(plan_of(2ms));
  until_trigger(link, 10);
  const std::uint32_t epoch = link.info().epoch;
  plugged_.unplug();
  until<LinkGone>(link);
  EXPECT_EQ(link.board(), nullptr);
  plugged_.plug();
  const auto back = until<LinkBack>(link);
  EXPECT_TRUE(std::get<LinkBack>(back.back()).was_reset);
  EXPECT_NE(link.info().epoch, epoch);
  const auto booted = until<TimedEvent>(link);
  EXPECT_EQ(std::get<TimedEvent>(booted.back()).event.kind, Event::Kind::Booted);
  EXPECT_EQ(link.last_status().state, RunState::Idle);
  link.board()->start(plan_of(2ms));
  expect_consecutive(sequences(until_trigger(link, 50)));
  EXPECT_EQ(link.counters().gone, 1u);
  EXPECT_EQ(link.counters().resets, 1u);
  link.board()->stop();
}

TEST_F(BoardLinkTest, AResetThatIsOverBeforeAnybodyLooksIsNoticed) {
  BoardLink link("", options_, bus_);
  link.board()->start(plan_of(2ms));
  until_trigger(link, 10);
  plugged_.reset();
  until<LinkGone>(link);
  EXPECT_TRUE(std::get<LinkBack>(until<LinkBack>(link).back()).was_reset);
}

TEST_F(BoardLinkTest, ABoardThatRanOnIsTakenUpWithoutLoss) {
  BoardLink link("", options_, bus_);
  link.board()->start(plan_of(2ms));
  const auto numbers = sequences(until_trigger(link, 10));
  plugged_.reconnect();
  std::this_thread::sleep_for(100ms);
  until<LinkGone>(link);
  EXPECT_FALSE(std::get<LinkBack>(until<LinkBack>(link).back()).was_reset);
  const auto after = sequences(until_trigger(link, 100));
  EXPECT_EQ(after.front(), numbers.back() + 1);
  expect_consecutive(after);
  EXPECT_EQ(link.counters().lost, 0u);
  link.board()->stop();
}

TEST_F(BoardLinkTest, AResetThatTheBusDidNotSeeIsFoundByTheEpoch) {
  options_.status_period = 10s;  // by that of the reports, that is
  BoardLink link("", options_, bus_);
  plugged_.reset_unnoticed();
  const auto back = until<LinkBack>(link);
  EXPECT_TRUE(std::get<LinkBack>(back.back()).was_reset);
  EXPECT_EQ(link.counters().gone, 0u);
  link.board()->start(plan_of(2ms));
  expect_consecutive(sequences(until_trigger(link, 20)));
}

TEST_F(BoardLinkTest, NonsenseAndLeftoversOfEarlierEpochsAreCountedAndDropped) {
  BoardLink link("", options_, bus_);
  link.next(1ms);
  const std::uint64_t from_before = link.counters().stale;
  glint_sync_input stale{};
  stale.report_id = GLINT_SYNC_INPUT;
  stale.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  stale.epoch = link.info().epoch - 1;
  stale.report_no = 3;
  stale.count = 1;
  stale.tick = ~0ull;
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&stale);
  plugged_.inject({bytes, bytes + sizeof stale});
  plugged_.inject({1, 2, 3});
  plugged_.inject(std::vector<std::uint8_t>(64, 1));
  link.board()->start(plan_of(2ms));
  const auto updates = until_trigger(link, 20);
  expect_consecutive(sequences(updates));
  EXPECT_EQ(link.counters().flawed, 2u);
  EXPECT_EQ(link.counters().stale, from_before + 1);
  EXPECT_EQ(link.counters().gone, 0u);
  EXPECT_EQ(link.counters().resets, 0u);
}

TEST_F(BoardLinkTest, LooksOnlyForItsOwnBoard) {
  PluggedBoard other(9);
  PluggedBus bus({&plugged_, &other});
  BoardLink link(plugged_.serial_text(), options_, bus);
  plugged_.unplug();
  until<LinkGone>(link);
  EXPECT_TRUE(std::holds_alternative<NothingYet>(link.next(50ms)));
  plugged_.plug();
  until<LinkBack>(link);
  EXPECT_EQ(link.info().serial, plugged_.serial_text());
}

TEST_F(BoardLinkTest, UntilPermissionIsGivenItKeepsTryingAndSaysWhy) {
  BoardLink link("", options_, bus_);
  plugged_.unplug();
  until<LinkGone>(link);
  plugged_.permitted = false;
  plugged_.plug();
  EXPECT_TRUE(std::holds_alternative<NothingYet>(link.next(30ms)));
  EXPECT_THAT(link.reopen_trouble(), ::testing::HasSubstr("permission"));
  plugged_.permitted = true;
  until<LinkBack>(link);
  EXPECT_EQ(link.reopen_trouble(), "");
}

TEST_F(BoardLinkTest, ThrowsWhereSyncBoardWould) {
  plugged_.unplug();
  EXPECT_THROW(BoardLink("", options_, bus_), NoBoard);
}

TEST_F(BoardLinkTest, TheClockIsAskedAboutTwentyTimesASecond) {
  BoardLink link("", options_, bus_);
  const std::size_t before = plugged_.queries;
  const HostTime deadline = HostClock::now() + 1s;
  while (HostClock::now() < deadline) link.next(10ms);
  EXPECT_GE(plugged_.queries - before, 5u);  // fewer on a busy machine
  EXPECT_LE(plugged_.queries - before, 22u);
}

TEST_F(BoardLinkTest, ExternalEdgesAreTriggers) {
  BoardLink link("", options_, bus_);
  BoardPlan plan = plan_of(1ms);
  plan.start = FrameStart::RisingEdge;
  link.board()->start(plan);
  EXPECT_EQ(link.board()->status().state, RunState::Waiting);
  for (std::uint64_t i = 0; i < 3; ++i) {
    std::this_thread::sleep_for(5ms);
    plugged_.edge_at_sync_in();
    const auto updates = until_trigger(link, i);
    EXPECT_TRUE(std::get<TimedTrigger>(updates.back()).trigger.external());
  }
  link.board()->stop();
}

}  // namespace
}  // namespace glint::sync
