// SPDX-License-Identifier: MIT
// From START to STOPPED, on the board's own clock.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/pulse_code.hpp"
#include "tests/unit/firmware/test_bench.hpp"

namespace glint::board {
namespace {

using ::testing::Each;
using ::testing::IsEmpty;
using ::testing::SizeIs;

std::vector<std::uint64_t> widths_of(const std::vector<Pulse>& pulses) {
  std::vector<std::uint64_t> widths;
  for (const Pulse& pulse : pulses) widths.push_back(pulse.width());
  return widths;
}

std::vector<std::uint64_t> periods_of(const std::vector<Pulse>& pulses) {
  std::vector<std::uint64_t> periods;
  for (std::size_t i = 1; i < pulses.size(); ++i) periods.push_back(pulses[i].rise - pulses[i - 1].rise);
  return periods;
}

TEST(Run, EveryOutputHasItsDelayAndWidthToTheTick) {
  TestBench board;
  board.stage_period_us(11'111);
  for (unsigned i = 0; i < 4; ++i) board.stage_output(i, 2000 * i, 1000);
  for (unsigned i = 0; i < 4; ++i) board.stage_output(4 + i, 788 + i, 137 + 40 * i);
  board.timer_delay = ticks_of_us(40);
  ASSERT_TRUE(board.start());
  board.run_us(1'000'000);
  const std::vector<Pulse> first = board.hardware.pulses(0);
  ASSERT_THAT(first, SizeIs(90));
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    const bool strobe = i >= 4;
    const std::vector<Pulse> pulses = board.hardware.pulses(i);
    EXPECT_THAT(widths_of(pulses), Each(ticks_of_us(strobe ? 137 + 40 * (i - 4) : 1000)));
    EXPECT_THAT(periods_of(pulses), Each(ticks_of_us(11'111)));
    EXPECT_EQ(pulses[0].rise - first[0].rise, ticks_of_us(strobe ? 788 + i - 4 : 2000 * i));
  }
}

TEST(Run, TriggersAreReportedWithTheTickInWhichTheirFrameBegan) {
  TestBench board;
  board.stage_period_us(11'111);
  board.stage_output(0, 0, 1000);
  board.stage_output(5, 788, 137);
  board.start();
  board.run_us(500'000);
  const std::vector<Pulse> pulses = board.hardware.pulses(0);
  const auto triggers = TestBench::triggers_in(board.take_reports());
  ASSERT_GE(pulses.size(), 44u);
  ASSERT_GE(triggers.size(), pulses.size());
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    EXPECT_EQ(triggers[i].tick, pulses[i].rise);
    EXPECT_EQ(triggers[i].sequence, i);
    EXPECT_EQ(triggers[i].outputs, 1 << 0 | 1 << 5);
    EXPECT_EQ(triggers[i].flags, 0);
  }
}

TEST(Run, ABurstEndsByItself) {
  TestBench board;
  board.stage_period_us(2000, 0, 7);
  board.stage_output(2, 100, 500);
  board.start();
  board.run_us(100'000);
  EXPECT_THAT(board.hardware.pulses(2), SizeIs(7));
  EXPECT_EQ(board.status().state, GLINT_SYNC_IDLE);
  EXPECT_EQ(board.status().stop_reason, GLINT_SYNC_STOP_BURST_END);
  const auto reports = board.take_reports();
  EXPECT_EQ(reports.back().kind, GLINT_SYNC_KIND_STOPPED);
  EXPECT_EQ(reports.back().detail, unsigned{GLINT_SYNC_STOP_BURST_END});
  EXPECT_EQ(reports.back().sequence, 7u);
  const auto triggers = TestBench::triggers_in(reports);
  ASSERT_THAT(triggers, SizeIs(7));
  EXPECT_EQ(triggers.back().flags, GLINT_SYNC_TRIGGER_LAST);
}

TEST(Run, ASingleShotIsABurstOfOne) {
  TestBench board;
  board.stage_period_us(2000, 0, 1);
  board.stage_output(0, 0, 500);
  for (int shot = 0; shot < 3; ++shot) {
    ASSERT_TRUE(board.start());
    EXPECT_FALSE(board.start()) << "while it runs";
    board.run_us(5000);
  }
  EXPECT_THAT(widths_of(board.hardware.pulses(0)), ::testing::ElementsAre(62'500, 62'500, 62'500));
  EXPECT_EQ(board.status().run, 3);
}

TEST(Run, StopLetsTheFramesThatArePlannedEnd) {
  TestBench board;
  board.stage_period_us(10'000);
  board.stage_output(0, 0, 5000);
  board.start();
  board.run_us(12'000);  // the second pulse is high
  ASSERT_TRUE(board.command(GLINT_SYNC_COMMAND_STOP));
  board.run_us(30'000);
  EXPECT_THAT(widths_of(board.hardware.pulses(0)), Each(ticks_of_us(5000)));
  EXPECT_EQ(board.status().state, GLINT_SYNC_IDLE);
  EXPECT_EQ(board.status().sequence, board.hardware.pulses(0).size());
}

TEST(Run, OutputsTakeTurns) {
  TestBench board;
  board.stage_period_us(4000);
  board.stage_output(0, 0, 100);
  board.stage_output(1, 0, 100, 3, 1);
  board.start();
  board.run_us(100'000);
  const auto all = board.hardware.pulses(0), third = board.hardware.pulses(1);
  ASSERT_GE(third.size(), 7u);
  for (std::size_t i = 0; i < third.size(); ++i) EXPECT_EQ(third[i].rise, all[3 * i + 1].rise);
}

TEST(Run, ANewRateBeginsWithAFrameAndNoPulseIsWrong) {
  TestBench board;
  board.stage_period_us(11'111);
  board.stage_output(0, 0, 1000);
  board.stage_output(4, 788, 100);
  board.start();
  for (int change = 0; change < 40; ++change) {
    board.run_us(100'000 + 317 * static_cast<unsigned>(change));
    board.stage_period_us(change % 2 == 0 ? 4000 : 11'111);
    ASSERT_TRUE(board.command(GLINT_SYNC_COMMAND_APPLY));
    board.run_us(50'000);
  }
  for (const unsigned output : {0u, 4u}) {
    EXPECT_THAT(widths_of(board.hardware.pulses(output)), Each(ticks_of_us(output == 0 ? 1000 : 100)));
    EXPECT_THAT(periods_of(board.hardware.pulses(output)),
                Each(::testing::AnyOf(ticks_of_us(4000), ticks_of_us(11'111))));
  }
  EXPECT_EQ(board.status().held_strobes, 0u);
}

TEST(Run, SettingsTakeEffectTogetherAndOnlyWhenApplied) {
  TestBench board;
  board.stage_period_us(4000);
  board.stage_output(0, 0, 100);
  board.start();
  board.run_us(20'000);
  board.stage_output(0, 50, 300);
  board.stage_output(1, 60, 400);
  board.run_us(20'000);
  EXPECT_THAT(board.hardware.pulses(1), IsEmpty());
  board.command(GLINT_SYNC_COMMAND_APPLY);
  board.run_us(20'000);
  const std::uint32_t since = board.status().applied_sequence;
  const auto pulses = board.hardware.pulses(0), second = board.hardware.pulses(1);
  ASSERT_GT(pulses.size(), since);
  for (std::size_t i = 0; i < pulses.size(); ++i)
    EXPECT_EQ(pulses[i].width(), ticks_of_us(i < since ? 100 : 300)) << i;
  EXPECT_EQ(second[0].rise, pulses[since].rise + ticks_of_us(10));
}

TEST(Run, WhatWouldOverlapMakesTheFrameWait) {
  TestBench board;
  board.stage_period_us(4000);
  board.stage_output(0, 3900, 1500);  // ends 1.4 ms after the next frame began
  board.start();
  board.run_us(30'000);
  board.stage_output(0, 0, 500);
  ASSERT_TRUE(board.command(GLINT_SYNC_COMMAND_APPLY));
  board.run_us(30'000);
  const auto pulses = board.hardware.pulses(0);
  const std::uint32_t since = board.status().applied_sequence;
  EXPECT_EQ(pulses[since].rise, pulses[since - 1].fall + kMinGap);
  EXPECT_EQ(pulses[since].width(), ticks_of_us(500));
}

TEST(Run, APlanThatIsRefusedWhileRunningChangesNothing) {
  TestBench board;
  board.stage_period_us(11'111);
  board.stage_output(4, 788, 265);
  board.start();
  board.run_us(50'000);
  board.stage_period_us(4000);
  EXPECT_FALSE(board.command(GLINT_SYNC_COMMAND_APPLY));
  EXPECT_EQ(board.status().refusal, GLINT_SYNC_REFUSED_STROBE_DUTY);
  EXPECT_EQ(board.status().refusal_output, 4);
  board.run_us(100'000);
  EXPECT_THAT(periods_of(board.hardware.pulses(4)), Each(ticks_of_us(11'111)));
}

TEST(Run, DarkFramesAreThoseOfTheCode) {
  TestBench board;
  board.stage_period_us(11'111);
  board.stage_output(0, 0, 1000);
  board.stage_output(4, 788, 137);
  auto run = board.get<glint_sync_run>(GLINT_SYNC_RUN);
  run.code_seed = 4711;
  run.code_group = 30;
  board.set(GLINT_SYNC_RUN, run);
  board.start();
  board.run_us(11'111 * 1000);
  const PulseCode code(4711, 30);
  const auto all = board.hardware.pulses(0), lit = board.hardware.pulses(4);
  ASSERT_GE(all.size(), 990u);
  std::size_t next = 0;
  for (std::size_t i = 0; i + 1 < all.size(); ++i) {
    if (code.dark(i)) continue;
    ASSERT_EQ(lit[next].rise, all[i].rise + ticks_of_us(788)) << "frame " << i;
    ++next;
  }
  EXPECT_LT(next, all.size() - 30);
}

TEST(Run, DarkFramesMayBeShortInstead) {
  TestBench board;
  board.stage_period_us(11'111);
  board.stage_output(4, 788, 137);
  auto run = board.get<glint_sync_run>(GLINT_SYNC_RUN);
  run.code_group = 18;
  run.dark_width_ticks = ticks_of_us(20);
  board.set(GLINT_SYNC_RUN, run);
  board.start();
  board.run_us(11'111 * 40);
  const auto pulses = board.hardware.pulses(4);
  ASSERT_GE(pulses.size(), 36u);
  int shorter = 0;
  for (std::size_t i = 0; i < 36; ++i) shorter += pulses[i].width() == ticks_of_us(20);
  EXPECT_EQ(shorter, 2) << "one of each 18";
}

TEST(Run, StopsWhenItsHostIsGone) {
  TestBench board;
  board.stage_period_us(100'000);
  board.stage_output(0, 0, 1000);
  auto run = board.get<glint_sync_run>(GLINT_SYNC_RUN);
  run.keepalive_ms = 250;
  board.set(GLINT_SYNC_RUN, run);
  board.start();
  for (int i = 0; i < 10; ++i) {
    board.run_us(200'000);
    board.command(GLINT_SYNC_COMMAND_KEEP_ALIVE);
  }
  EXPECT_EQ(board.status().state, GLINT_SYNC_RUNNING);
  board.run_us(249'000);
  EXPECT_TRUE(board.device.running());
  board.run_us(152'000);
  EXPECT_FALSE(board.device.running());
  EXPECT_EQ(board.status().stop_reason, GLINT_SYNC_STOP_HOST_GONE);
}

TEST(Run, StopsWhenTheBusIsGoneIfItNeedsItsHost) {
  for (const std::uint16_t keepalive_ms : {std::uint16_t{0}, std::uint16_t{5000}}) {
    TestBench board;
    board.stage_period_us(10'000);
    board.stage_output(0, 0, 1000);
    auto run = board.get<glint_sync_run>(GLINT_SYNC_RUN);
    run.keepalive_ms = keepalive_ms;
    board.set(GLINT_SYNC_RUN, run);
    board.start();
    board.run_us(50'000);
    board.device.on_bus_lost(board.now);
    board.run_us(50'000);
    EXPECT_EQ(board.device.running(), keepalive_ms == 0);
  }
}

TEST(Run, ALateTimerIsAFaultAndNoWrongPulse) {
  TestBench board;
  board.stage_period_us(1000);
  board.stage_output(0, 0, 300);
  board.start();
  board.run_us(20'000);
  board.timer_delay = ticks_of_us(70);
  board.run_us(20'000);
  EXPECT_EQ(board.status().fault, GLINT_SYNC_FAULT_UNDERRUN);
  EXPECT_FALSE(board.device.running());
  EXPECT_THAT(periods_of(board.hardware.pulses(0)), Each(ticks_of_us(1000)));
  EXPECT_FALSE(board.start());
  EXPECT_EQ(board.status().refusal, GLINT_SYNC_REFUSED_FAULT);
  board.timer_delay = 0;
  board.command(GLINT_SYNC_COMMAND_CLEAR);
  EXPECT_TRUE(board.start());
}

TEST(Run, OutputsThatDoNotBeginAreAFault) {
  TestBench board;
  board.stage_period_us(1000);
  board.stage_output(0, 0, 300);
  board.start();
  board.run_us(20'000);
  board.hardware.stuck = true;
  board.run_us(5000);
  EXPECT_EQ(board.status().fault, GLINT_SYNC_FAULT_STALLED);
}

TEST(Run, TheSelfTestMeasuresTheOutputThatIsWired) {
  TestBench board;
  for (const int wired : {3, 6, -1}) {
    board.hardware.measured_wire = wired;
    const unsigned tested = wired < 0 ? 0 : static_cast<unsigned>(wired);
    board.hardware.forget_pulses();
    ASSERT_TRUE(board.command(GLINT_SYNC_COMMAND_SELFTEST, tested));
    board.run_us(100'000);
    EXPECT_EQ(board.get<glint_sync_selftest>(GLINT_SYNC_SELFTEST).state, GLINT_SYNC_SELFTEST_RUNNING);
    EXPECT_EQ(board.status().state, GLINT_SYNC_TESTING);
    board.run_us(400'000);
    const auto result = board.get<glint_sync_selftest>(GLINT_SYNC_SELFTEST);
    EXPECT_EQ(result.state, GLINT_SYNC_SELFTEST_DONE);
    EXPECT_EQ(result.output, tested);
    EXPECT_EQ(result.sent, 32u);
    EXPECT_EQ(result.seen, wired < 0 ? 0u : 32u);
    if (wired < 0) continue;
    EXPECT_EQ(result.least_width_ticks, result.width_ticks);
    EXPECT_EQ(result.most_width_ticks, result.width_ticks);
    EXPECT_EQ(result.least_period_ticks, result.period_ticks);
    EXPECT_EQ(result.most_period_ticks, result.period_ticks);
  }
  EXPECT_TRUE(TestBench::triggers_in(board.take_reports()).empty()) << "the test is no run";
}

}  // namespace
}  // namespace glint::board
