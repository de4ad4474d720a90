// SPDX-License-Identifier: MIT
// What is printed says what it should.
#include "host/apps/sync_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <sstream>

#include "host/apps/sync_json.hpp"
#include "host/apps/sync_selftest.hpp"
#include "host/apps/sync_watch_output.hpp"

namespace glint::apps {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr std::uint32_t kTickHz = 125'000'000;

sync::Info some_board() {
  sync::Info info;
  info.serial = "E660000000000008";
  info.protocol_major = 1;
  info.firmware_version = 0x000203;
  info.build = "abcdef0123";
  info.tick_hz = kTickHz;
  return info;
}

sync::BoardPlan some_plan() {
  sync::BoardPlan plan;
  plan.outputs[0] = {.enabled = true, .width = 100us};
  plan.outputs[4] = {.enabled = true,
                     .active_low = true,
                     .delay = 788us,
                     .width = sync::Seconds(137.5e-6),
                     .every_n = 2,
                     .phase = 1};
  return plan;
}

sync::Limits some_limits() {
  return {.lockout_v = 14.0,
          .rearm_v = 13.8,
          .strobe_max_duty = 0.025,
          .strobe_max_width = 300us,
          .min_period = 500us,
          .max_period = 10s,
          .min_width = 1us,
          .min_gap = 1us};
}

TEST(SyncText, PinsAreThoseOfTheBoard) {
  EXPECT_EQ(output_pin(0), "GP2");
  EXPECT_EQ(output_pin(7), "GP9");
}

TEST(SyncText, ThePlanShowsWhatTheGridMakesOfIt) {
  const sync::BoardPlan asked = some_plan();
  const std::string text = plan_text(sync::on_grid(asked, kTickHz), asked, kTickHz);
  EXPECT_THAT(text, HasSubstr("89.999993 Hz: period 11111.112 us, 1388889 ticks of 8 ns (asked for 90 Hz)"));
  EXPECT_THAT(text, HasSubstr("0      GP2  trigger        0.000      100.000  all\n"));
  EXPECT_THAT(
      text, HasSubstr("4      GP6  strobe       788.000      137.504  one in 2, from frame 1 on, active low "
                      "(asked for width 137.5 us)\n"));
  EXPECT_THAT(text, HasSubstr("1, 2, 3, 5, 6, 7"));
  EXPECT_THAT(text, Not(HasSubstr("keep-alive")));
}

TEST(SyncText, ThePlanShowsWhatIsUnusual) {
  sync::BoardPlan plan = some_plan();
  plan.start = sync::FrameStart::FallingEdge;
  plan.pulses = 1;
  plan.keepalive = 500ms;
  plan.sync_out = true;
  plan.code = {7, 30, 10us};
  const std::string text = plan_text(plan, plan, kTickHz);
  EXPECT_THAT(text, AllOf(HasSubstr("falling edges at sync in (GP14)"), HasSubstr("1 frame, then"),
                          HasSubstr("500 ms without"), HasSubstr("repeats output 0"),
                          HasSubstr("one frame in 30 is dark, seed 7, strobes last 10.000 us there")));
  EXPECT_THAT(text, Not(HasSubstr("asked for")));
  EXPECT_THAT(plan_text(sync::BoardPlan{}, sync::BoardPlan{}, kTickHz), HasSubstr("all off"));
}

TEST(SyncText, TheStatusOfABoardAtWork) {
  sync::Status status;
  status.state = sync::RunState::Running;
  status.run = 3;
  status.sequence = 1234;
  status.supply_v = 12.03;
  const std::string text = status_text(some_board(), status, some_limits(), some_plan());
  EXPECT_THAT(text, HasSubstr("sync board E660000000000008, firmware 0.2.3 (abcdef0123), protocol 1.0\n"));
  EXPECT_THAT(text, HasSubstr("running, run 3, 1234 frames\n"));
  EXPECT_THAT(text, HasSubstr("12.03 V; strobes are locked out above 14.00 V\n"));
  EXPECT_THAT(text, HasSubstr("strobes 300.000 us and 2.5 % of the time at most"));
  EXPECT_THAT(text, HasSubstr("0.1 to 2000 Hz"));
  EXPECT_THAT(text, HasSubstr("staged settings\n"));
}

TEST(SyncText, TheStatusOfABoardInTrouble) {
  sync::Status status;
  status.run = 3;
  status.sequence = 1;
  status.supply_v = 14.2;
  status.supply_locked = true;
  status.lockouts = 1;
  status.stop_reason = GLINT_SYNC_STOP_FAULT;
  status.fault = GLINT_SYNC_FAULT_UNDERRUN;
  status.after_watchdog = true;
  status.reset_reason = GLINT_SYNC_RESET_WATCHDOG;
  status.unsent = 5;
  status.ignored_edges = 2;
  status.held_strobes = 1;
  const std::string text = status_text(some_board(), status, some_limits(), some_plan());
  EXPECT_THAT(text, HasSubstr("idle; run 3 ended after 1 frame because of a fault\n"));
  EXPECT_THAT(text,
              HasSubstr("14.20 V: too high, STROBES ARE LOCKED OUT until it is below 13.80 V; 1 lockout"));
  EXPECT_THAT(text, HasSubstr("a pulse was not ready in time: remove the cause, then glint sync clear"));
  EXPECT_THAT(text, HasSubstr("the watchdog: the firmware had hung"));
  EXPECT_THAT(text,
              HasSubstr("5 reports not taken by the host; 2 edges at sync in came too soon; 1 strobe held"));
}

TEST(SyncText, WhatBecameOfAStart) {
  RunOutcome outcome;
  outcome.plan = some_plan();
  outcome.plan.code = {7, 30, sync::Seconds(0.0)};
  outcome.run = 4;
  outcome.first_frame = 600us;
  std::string text = run_text(outcome, outcome.plan, kTickHz);
  EXPECT_THAT(text, HasSubstr("run 4 has started; first frame 0.600 ms after the command\n"));
  EXPECT_THAT(text, HasSubstr("code_seed = 7, code_group = 30\n"));
  EXPECT_THAT(text, Not(HasSubstr("LOCKED")));
  outcome.kind = RunOutcome::Kind::Restarted;
  outcome.previous_run = 3;
  outcome.plan.start = sync::FrameStart::RisingEdge;
  outcome.supply_locked = true;
  text = run_text(outcome, outcome.plan, kTickHz);
  EXPECT_THAT(text, AllOf(HasSubstr("run 3 was ended, for"),
                          HasSubstr("run 4 has started; it waits for a rising edge at sync in (GP14)"),
                          HasSubstr("STROBES ARE LOCKED OUT")));
  outcome.kind = RunOutcome::Kind::Applied;
  outcome.applied_sequence = 17;
  EXPECT_THAT(run_text(outcome, outcome.plan, kTickHz),
              HasSubstr("run 4 goes on, with the new settings from frame 17"));
}

TEST(SyncText, AChangeWithoutARunSaysHowToBeginOne) {
  ChangeOutcome outcome;
  outcome.plan = some_plan();
  EXPECT_THAT(change_text(outcome, 4, outcome.plan, kTickHz),
              AllOf(HasSubstr("glint sync start"), HasSubstr("GP6"), Not(HasSubstr("GP2"))));
  EXPECT_THAT(change_text(outcome, 5, outcome.plan, kTickHz), HasSubstr("off"));
  outcome.run.emplace();
  outcome.run->kind = RunOutcome::Kind::Applied;
  outcome.run->run = 2;
  EXPECT_THAT(change_text(outcome, 4, outcome.plan, kTickHz), HasSubstr("run 2 goes on"));
}

TEST(SyncText, WhatBecameOfAStop) {
  StopOutcome outcome;
  EXPECT_EQ(stopped_text(outcome), "nothing was running\n");
  outcome.was_running = true;
  outcome.state = sync::RunState::Running;
  outcome.status.run = 2;
  outcome.status.sequence = 900;
  EXPECT_EQ(stopped_text(outcome), "run 2 has ended after 900 frames\n");
}

sync::SelfTestResult some_result(int output) {
  sync::SelfTestResult result;
  result.state = sync::SelfTestResult::State::Done;
  result.output = output;
  result.sent = result.seen = 32;
  result.resolution = 16ns;
  result.width = result.most_width = 137us;
  result.least_width = 137us - 8ns;
  result.period = result.least_period = 10ms;
  result.most_period = 10ms + 16ns;
  return result;
}

TEST(SyncText, ResultsOfTheSelfTest) {
  sync::SelfTestResult result = some_result(4);
  EXPECT_EQ(
      self_test_text(result),
      "output 4 (strobe), GP6: passed, 32 of 32 pulses; width 137.000 us, measured -0.008 to +0.000 us off; "
      "period 10000.000 us, measured +0.000 to +0.016 us off; the board measures to 0.016 us");
  result.seen = 31;
  EXPECT_THAT(self_test_text(result), HasSubstr("FAILED, 31 of 32"));
  result.seen = 0;
  EXPECT_THAT(self_test_text(result), HasSubstr("no wire from there to GP14"));
}

TEST(SyncText, VerdictsOfTheSelfTest) {
  sync::SelfTestResult bad = some_result(1), absent = some_result(2);
  bad.seen = 31;
  absent.seen = 0;
  EXPECT_EQ(self_test_verdict({some_result(0)}, true), "");
  EXPECT_EQ(self_test_verdict({some_result(0), absent}, false), "");
  EXPECT_THAT(self_test_verdict({some_result(0), absent}, true), HasSubstr("output 2"));
  EXPECT_THAT(self_test_verdict({some_result(0), bad, absent}, false), HasSubstr("output 1"));
  EXPECT_THAT(self_test_verdict({absent}, false), HasSubstr("no wire"));
}

TEST(SyncJson, ThePlanHasAllOutputsInMicroseconds) {
  const auto json = plan_json(sync::on_grid(some_plan(), kTickHz), kTickHz);
  EXPECT_EQ(json["period_ticks"], 1388889);
  EXPECT_EQ(json["period_us"].dump(), "11111.112");
  ASSERT_EQ(json["outputs"].size(), 8u);
  EXPECT_EQ(json["outputs"][4]["width_us"].dump(), "137.504");
  EXPECT_EQ(json["outputs"][4]["pin"], "GP6");
  EXPECT_EQ(json["outputs"][5]["enabled"], false);
}

WatchUpdate some_update() {
  WatchUpdate update;
  update.since_start_s = 12.0;
  update.state = sync::RunState::Running;
  update.supply_v = 12.034;
  update.window.rate_hz = 90.0;
  update.window.delay = {90, 0.41e-3, 0.97e-3, 1.02e-3};
  update.counters.fetched = 3;
  update.clock_bound_s = 14e-6;
  return update;
}

TEST(WatchLine, OneLineSaysItAll) {
  WatchUpdate update = some_update();
  EXPECT_EQ(
      watch_line(update),
      "     12.0 s  running  90.000 Hz  delay 0.41/0.97/1.02 ms  12.03 V  0 lost, 3 fetched  clock +-14 us");
  update.supply_locked = true;
  update.fault = GLINT_SYNC_FAULT_STALLED;
  EXPECT_THAT(watch_line(update), AllOf(HasSubstr("LOCKED OUT"), HasSubstr("FAULT: a pulse that was due")));
  update.present = false;
  update.trouble = "no permission";
  EXPECT_EQ(watch_line(update), "     12.0 s  no board: no permission");
}

/// What a sink wrote.
class SinkOutput : public ::testing::Test {
 protected:
  SinkOutput() : file_(std::tmpfile(), &std::fclose) {}
  std::string written() const {
    std::rewind(file_.get());
    std::string text;
    for (int c; (c = std::fgetc(file_.get())) != EOF;) text += static_cast<char>(c);
    return text;
  }
  static void fill(WatchSink& sink) {
    sink.begin(some_board());
    WatchEvent event;
    event.since_start_s = 1.5;
    event.kind = "started";
    event.text = "run 1 has started";
    event.run = 1;
    event.when = sync::HostInterval{sync::HostTime(2s), 14us};
    sink.event(event);
    sink.update(some_update());
    WatchSummary summary;
    summary.frames.seen = 90;
    sink.end(summary);
  }

  std::unique_ptr<std::FILE, decltype(&std::fclose)> file_;
};

TEST_F(SinkOutput, TextIsALineEach) {
  fill(*make_text_sink(file_.get()));
  const std::string text = written();
  EXPECT_THAT(text, HasSubstr("\n    1.500 s  run 1 has started\n     12.0 s  running"));
  EXPECT_THAT(text, HasSubstr("frames   90, and 0 missing"));
  EXPECT_THAT(text, Not(HasSubstr("\r")));
}

TEST_F(SinkOutput, JsonIsAnObjectALine) {
  fill(*make_json_sink(file_.get()));
  std::istringstream lines(written());
  std::vector<nlohmann::json> all;
  for (std::string line; std::getline(lines, line);) all.push_back(nlohmann::json::parse(line));
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0]["type"], "board");
  EXPECT_EQ(all[0]["serial"], "E660000000000008");
  EXPECT_EQ(all[1]["event"], "started");
  EXPECT_EQ(all[1]["time_ns"], 2'000'000'000);
  EXPECT_DOUBLE_EQ(all[1]["time_error_s"], 14e-6);
  EXPECT_DOUBLE_EQ(all[2]["rate_hz"], 90.0);
  EXPECT_DOUBLE_EQ(all[2]["report_delay"]["p99_s"], 0.97e-3);
  EXPECT_EQ(all[2]["reports"]["fetched"], 3);
  EXPECT_EQ(all[3]["frames"], 90);
}

}  // namespace
}  // namespace glint::apps
