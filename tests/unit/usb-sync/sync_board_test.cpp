// SPDX-License-Identifier: MIT
// Talks to the board's own logic, as it runs in the firmware.
#include "usb-sync/sync_board.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <thread>

#include "tests/unit/usb-sync/plugged_board.hpp"

namespace glint::sync {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;

template <class Work>
std::string error_of(Work&& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

BoardPlan good_plan() {
  BoardPlan plan;
  plan.period = 2ms;
  plan.outputs[0] = {.enabled = true, .width = 1ms};
  plan.outputs[4] = {.enabled = true, .delay = 788us, .width = 40us};
  return plan;
}

class SyncBoardTest : public ::testing::Test {
 protected:
  PluggedBoard plugged_;
  PluggedBus bus_{{&plugged_}};
};

TEST_F(SyncBoardTest, OpensTheOnlyBoard) {
  const SyncBoard board = SyncBoard::open("", bus_);
  EXPECT_EQ(board.info().serial, plugged_.serial_text());
  EXPECT_EQ(board.info().tick_hz, 125'000'000u);
  EXPECT_EQ(board.info().firmware_text(), "0.2.3");
  EXPECT_EQ(board.info().build, "abcdef0123");
}

TEST_F(SyncBoardTest, WithoutABoardItSaysWhatToDo) {
  plugged_.unplug();
  EXPECT_THROW(SyncBoard::open("", bus_), NoBoard);
  EXPECT_THAT(error_of([&] { SyncBoard::open("", bus_); }), HasSubstr("connect it by USB"));
}

TEST_F(SyncBoardTest, OfSeveralBoardsTheSerialNumberDecides) {
  PluggedBoard other(9);
  PluggedBus bus({&plugged_, &other});
  EXPECT_EQ(SyncBoard::open("e660000000000009", bus).info().serial, other.serial_text());
  EXPECT_THAT(error_of([&] { SyncBoard::open("", bus); }),
              AllOf(HasSubstr("several"), HasSubstr(plugged_.serial_text()), HasSubstr(other.serial_text())));
  EXPECT_THAT(error_of([&] { SyncBoard::open("E66000000000000A", bus); }),
              AllOf(HasSubstr("E66000000000000A"), HasSubstr("there is: " + plugged_.serial_text())));
  EXPECT_EQ(find_boards(bus).size(), 2u);
}

TEST_F(SyncBoardTest, AnotherMajorProtocolIsRefusedWithAdvice) {
  plugged_.protocol = 0;
  EXPECT_THAT(error_of([&] { SyncBoard::open("", bus_); }),
              AllOf(HasSubstr("protocol 0"), HasSubstr("glint sync flash")));
  plugged_.protocol = GLINT_SYNC_PROTOCOL_MAJOR + 1;
  EXPECT_THAT(error_of([&] { SyncBoard::open("", bus_); }), HasSubstr("use a newer glint"));
}

TEST_F(SyncBoardTest, APlanComesBackAsItWasStaged) {
  SyncBoard board = SyncBoard::open("", bus_);
  BoardPlan plan = good_plan();
  plan.period = Seconds(1.0 / 90.0);
  plan.sync_out = true;
  plan.keepalive = 500ms;
  plan.pulses = 12;
  plan.code = {.seed = 3, .group = 30, .dark_width = 10us};
  plan.outputs[7] = {.enabled = true, .delay = 1ms, .width = 30us, .every_n = 3, .phase = 2};
  const BoardPlan real = board.stage(plan);
  EXPECT_NE(real.period, plan.period);  // 1/90 s is on no tick
  EXPECT_NEAR(real.period.count(), plan.period.count(), 4e-9);
  EXPECT_EQ(board.staged(), real);
  EXPECT_EQ(board.status().state, RunState::Idle);
}

TEST_F(SyncBoardTest, ARunSendsItsReports) {
  SyncBoard board = SyncBoard::open("", bus_);
  BoardPlan plan = good_plan();
  plan.pulses = 20;
  board.start(plan);
  std::uint32_t triggers = 0;
  bool started = false, stopped = false;
  while (!stopped) {
    const ReadResult result = board.read(500ms);
    ASSERT_EQ(result.kind, ReadResult::Kind::Report);
    if (const auto* event = std::get_if<Event>(&result.report.content)) {
      started = started || event->kind == Event::Kind::Started;
      stopped = event->kind == Event::Kind::Stopped;
      continue;
    }
    for (const Trigger& trigger : std::get<Triggers>(result.report.content).all()) {
      EXPECT_EQ(trigger.sequence, triggers++);
      EXPECT_EQ(trigger.outputs, 0x11);
    }
  }
  EXPECT_TRUE(started);
  EXPECT_EQ(triggers, 20u);
  EXPECT_EQ(board.read(0ms).kind, ReadResult::Kind::Nothing);
}

TEST_F(SyncBoardTest, TheRunningPlanChangesOnCommand) {
  SyncBoard board = SyncBoard::open("", bus_);
  board.start(good_plan());
  EXPECT_EQ(board.status().state, RunState::Running);
  BoardPlan faster = good_plan();
  faster.period = 1800us;
  board.apply(faster);
  bool applied = false;
  while (!applied) {
    const ReadResult result = board.read(500ms);
    ASSERT_EQ(result.kind, ReadResult::Kind::Report);
    const auto* event = std::get_if<Event>(&result.report.content);
    applied = event != nullptr && event->kind == Event::Kind::Applied;
  }
  board.stop();
}

TEST_F(SyncBoardTest, RefusalsNameTheOutputAndTheLimit) {
  SyncBoard board = SyncBoard::open("", bus_);
  BoardPlan plan = good_plan();
  plan.period = 20ms;
  plan.outputs[4].width = 301us;
  try {
    board.start(plan);
    FAIL();
  } catch (const Refused& refused) {
    EXPECT_STREQ(refused.what(),
                 "the sync board will not start: output 4 (strobe): the light may be on for at most 300 us");
    EXPECT_EQ(refused.reason(), GLINT_SYNC_REFUSED_STROBE_WIDTH);
    EXPECT_EQ(refused.output(), 4);
  }
  plan = good_plan();
  plan.outputs[4].width = 60us;  // 3 % of 2 ms
  EXPECT_THAT(error_of([&] { board.start(plan); }), HasSubstr("2.5 % of the time"));
  plan = good_plan();
  plan.outputs[0].width = 3ms;
  EXPECT_THAT(error_of([&] { board.start(plan); }), HasSubstr("output 0 (trigger)"));
  plan = good_plan();
  plan.period = 100us;
  EXPECT_THAT(error_of([&] { board.start(plan); }), HasSubstr("Hz) at least"));
  plan = good_plan();
  plan.outputs[4].active_low = true;
  EXPECT_THAT(error_of([&] { board.start(plan); }),
              HasSubstr("the jumper on the board makes strobes active high"));
  EXPECT_THAT(error_of([&] { board.start(BoardPlan{}); }), HasSubstr("no output is switched on"));
  EXPECT_THAT(error_of([&] { board.apply(good_plan()); }), HasSubstr("nothing runs"));
  board.start(good_plan());
  EXPECT_THAT(error_of([&] { board.start(good_plan()); }), HasSubstr("stop it first"));
  board.stop();
}

TEST_F(SyncBoardTest, LimitsCanBeLoweredButNotLifted) {
  SyncBoard board = SyncBoard::open("", bus_);
  Limits limits = board.limits();
  const Limits caps = limits;
  limits.strobe_max_width = 100us;
  limits.lockout_v = 13.0;
  limits.rearm_v = 12.5;
  EXPECT_DOUBLE_EQ(board.set_limits(limits).strobe_max_width.count(), 100e-6);
  EXPECT_DOUBLE_EQ(board.limits().lockout_v, 13.0);
  limits = caps;
  limits.lockout_v += 0.001;
  EXPECT_THROW(board.set_limits(limits), Refused);
  limits = caps;
  limits.strobe_max_width += 1us;
  EXPECT_THAT(error_of([&] { board.set_limits(limits); }), HasSubstr("nobody can lift"));
  EXPECT_DOUBLE_EQ(board.limits().lockout_v, 13.0);
}

TEST_F(SyncBoardTest, ASupplyThatIsTooHighShowsInTheStatus) {
  SyncBoard board = SyncBoard::open("", bus_);
  EXPECT_FALSE(board.status().supply_locked);
  plugged_.supply_mv = 14'300;
  std::this_thread::sleep_for(20ms);
  const Status status = board.status();
  EXPECT_TRUE(status.supply_locked);
  EXPECT_NEAR(status.supply_v, 14.3, 0.05);
  EXPECT_EQ(status.lockouts, 1);
  EXPECT_THAT(error_of([&] { board.self_test(4); }), HasSubstr("strobes are locked out"));
}

TEST_F(SyncBoardTest, TheSelfTestMeasuresTheWire) {
  SyncBoard board = SyncBoard::open("", bus_);
  plugged_.measured_wire = 1;
  const SelfTestResult wired = board.self_test(1);
  EXPECT_TRUE(wired.passed());
  EXPECT_EQ(wired.output, 1);
  const SelfTestResult open = board.self_test(2);
  EXPECT_FALSE(open.passed());
  EXPECT_EQ(open.seen, 0u);
}

TEST_F(SyncBoardTest, TheCounterWasReadBetweenTheQuestionAndTheAnswer) {
  SyncBoard board = SyncBoard::open("", bus_);
  const auto first = board.ask_time();
  std::this_thread::sleep_for(10ms);
  const auto second = board.ask_time();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->epoch, plugged_.epoch());
  EXPECT_LE(first->asked, first->answered);
  const Seconds passed = seconds_of(second->tick - first->tick, board.info().tick_hz);
  EXPECT_LE(passed, Seconds(second->answered - first->asked) + 16ns);
  EXPECT_GE(passed, Seconds(second->asked - first->answered) - 16ns);
}

TEST_F(SyncBoardTest, ReportsCanBeFetchedAgain) {
  SyncBoard board = SyncBoard::open("", bus_);
  board.read(0ms);  // so that the first report is sent
  const auto booted = board.fetch(0);
  ASSERT_TRUE(booted);
  EXPECT_EQ(std::get<Event>(booted->content).kind, Event::Kind::Booted);
  const auto to_come = board.fetch(1000);
  ASSERT_TRUE(to_come);
  EXPECT_TRUE(std::holds_alternative<NotHeld>(to_come->content));
}

TEST_F(SyncBoardTest, ReportsThatAreNoneAreToldApart) {
  SyncBoard board = SyncBoard::open("", bus_);
  while (board.read(0ms).kind == ReadResult::Kind::Report) {
  }
  plugged_.inject({GLINT_SYNC_INPUT});
  plugged_.inject(std::vector<std::uint8_t>(500, GLINT_SYNC_INPUT));
  plugged_.inject(std::vector<std::uint8_t>(GLINT_SYNC_REPORT_BYTES, 0xee));
  for (const Flaw flaw : {Flaw::Length, Flaw::Length, Flaw::ReportId}) {
    const ReadResult result = board.read(0ms);
    EXPECT_EQ(result.kind, ReadResult::Kind::Flawed);
    EXPECT_EQ(result.flaw, flaw);
  }
}

TEST_F(SyncBoardTest, AnUnpluggedBoardIsGoneAndNotRefusing) {
  SyncBoard board = SyncBoard::open("", bus_);
  plugged_.unplug();
  EXPECT_EQ(board.read(100ms).kind, ReadResult::Kind::Gone);
  EXPECT_FALSE(board.ask_time());
  EXPECT_FALSE(board.fetch(0));
  EXPECT_FALSE(board.try_status());
  EXPECT_THROW(board.status(), BoardGone);
  EXPECT_THROW(board.start(good_plan()), BoardGone);
  EXPECT_THAT(error_of([&] { board.stop(); }), HasSubstr(plugged_.serial_text()));
}

TEST_F(SyncBoardTest, ResetAndBootloaderEndTheConnection) {
  {
    SyncBoard board = SyncBoard::open("", bus_);
    const std::uint32_t epoch = board.info().epoch;
    board.reset();
    EXPECT_EQ(board.read(0ms).kind, ReadResult::Kind::Gone);
    EXPECT_NE(SyncBoard::open("", bus_).info().epoch, epoch);
  }
  SyncBoard board = SyncBoard::open("", bus_);
  board.enter_bootloader();
  EXPECT_THROW(SyncBoard::open("", bus_), NoBoard);
}

}  // namespace
}  // namespace glint::sync
