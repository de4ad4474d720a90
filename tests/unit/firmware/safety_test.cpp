// SPDX-License-Identifier: MIT
// The light: nothing that a host can say makes it shine longer or more often than the caps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <random>

#include "tests/unit/firmware/test_bench.hpp"

namespace glint::board {
namespace {

void run_strobes(TestBench& board) {
  board.stage_period_us(4000);
  board.stage_output(0, 0, 100);
  for (unsigned i = 4; i < 8; ++i) board.stage_output(i, 788, 100);
  ASSERT_TRUE(board.start());
}

TEST(Lockout, ComesWithTheSecondSampleAndLeavesTheTriggersAlone) {
  TestBench board;
  run_strobes(board);
  board.run_us(100'000);
  board.supply_mv = 14'200;
  const std::uint64_t crossing = board.now;
  board.run_us(50'000);
  EXPECT_TRUE(board.locked());
  const auto reports = board.take_reports();
  std::uint64_t locked_at = 0;
  for (const glint_sync_input& report : reports)
    if (report.kind == GLINT_SYNC_KIND_LOCKED) locked_at = report.tick;
  EXPECT_GT(locked_at, crossing);
  EXPECT_LE(locked_at, crossing + ticks_of_us(100));
  for (unsigned i = 4; i < 8; ++i) EXPECT_LE(board.hardware.pulses(i).back().fall, locked_at);
  EXPECT_GT(board.hardware.pulses(0).back().rise, board.now - ticks_of_us(8000));
  const auto triggers = TestBench::triggers_in(reports);
  EXPECT_EQ(triggers.back().outputs, 1);
  EXPECT_EQ(triggers.back().flags, GLINT_SYNC_TRIGGER_LOCKED);
}

TEST(Lockout, EndsBelowTheLowerLimitOnly) {
  TestBench board;
  run_strobes(board);
  board.run_us(50'000);
  board.supply_mv = 14'001;
  board.run_us(50'000);
  EXPECT_TRUE(board.locked());
  board.supply_mv = 13'800;
  board.run_us(200'000);
  EXPECT_TRUE(board.locked());
  board.supply_mv = 13'799;
  board.run_us(100'000);
  EXPECT_FALSE(board.locked());
  EXPECT_EQ(board.status().lockouts, 1);
  const std::size_t before = board.hardware.pulses(4).size();
  board.run_us(20'000);
  EXPECT_GT(board.hardware.pulses(4).size(), before);
  for (const Pulse& pulse : board.hardware.pulses(4)) EXPECT_EQ(pulse.width(), ticks_of_us(100));
}

TEST(Lockout, OneDisturbedSampleIsNone) {
  TestBench board;
  for (int i = 0; i < 100; ++i) {
    board.device.on_supply(16'000, board.now);
    board.device.on_supply(12'000, board.now);
  }
  EXPECT_FALSE(board.locked());
}

TEST(Lockout, ALowRateMakesNoHalfPulseWhenItEnds) {
  TestBench board;
  board.stage_period_us(1'000'000);
  board.stage_output(4, 0, 300);
  board.start();
  board.run_us(2'000'500 - 60 + 150);  // a strobe planned, or just shining
  board.supply_mv = 15'000;
  board.run_us(300);
  board.supply_mv = 12'000;
  board.run_us(5'000'000);
  int cut = 0;
  for (const Pulse& pulse : board.hardware.pulses(4)) cut += pulse.width() != ticks_of_us(300);
  EXPECT_LE(cut, 1) << "the one that was cut short by the lockout itself";
  EXPECT_GE(board.hardware.pulses(4).size(), 4u);
}

TEST(Lockout, WithoutSamplesThereIsNoRun) {
  TestBench board;
  run_strobes(board);
  board.run_us(20'000);
  board.supply_measured = false;
  board.run_us(20'000);
  EXPECT_EQ(board.status().fault, GLINT_SYNC_FAULT_SUPPLY);
  EXPECT_FALSE(board.device.running());
}

TEST(Limits, TheHostMayLowerThemAndRaiseThemAgainButNotAboveTheCaps) {
  TestBench board;
  auto limits = board.get<glint_sync_limits>(GLINT_SYNC_LIMITS);
  EXPECT_EQ(limits.lockout_mv, 14'000);
  EXPECT_EQ(limits.rearm_mv, 13'800);
  EXPECT_EQ(limits.strobe_max_duty_permille, 25);
  EXPECT_EQ(limits.strobe_max_width_ticks, ticks_of_us(300));
  const glint_sync_limits caps = limits;
  limits.lockout_mv = 13'000;
  limits.rearm_mv = 12'900;
  limits.strobe_max_duty_permille = 10;
  limits.strobe_max_width_ticks = ticks_of_us(100);
  EXPECT_TRUE(board.set(GLINT_SYNC_LIMITS, limits));
  EXPECT_EQ(board.get<glint_sync_limits>(GLINT_SYNC_LIMITS).lockout_mv, 13'000);
  EXPECT_TRUE(board.set(GLINT_SYNC_LIMITS, caps));

  const auto refused = [&](auto change) {
    glint_sync_limits wanted = caps;
    change(wanted);
    return !board.set(GLINT_SYNC_LIMITS, wanted);
  };
  EXPECT_TRUE(refused([](auto& wanted) { wanted.lockout_mv = 14'001; }));
  EXPECT_EQ(board.status().refusal, GLINT_SYNC_REFUSED_LOCKOUT);
  EXPECT_EQ(board.status().refusal_limit, 14'000u);
  EXPECT_TRUE(refused([](auto& wanted) { wanted.rearm_mv = 13'801; }));
  EXPECT_TRUE(refused([](auto& wanted) { wanted.lockout_mv = 13'850; }));
  EXPECT_TRUE(refused([](auto& wanted) { wanted.strobe_max_duty_permille = 26; }));
  EXPECT_TRUE(refused([](auto& wanted) { wanted.strobe_max_duty_permille = 0; }));
  EXPECT_TRUE(refused([](auto& wanted) { ++wanted.strobe_max_width_ticks; }));
}

/// What a ring of LEDs saw: no pulse longer than the cap, and after each as long a pause as the cap of the
/// duty wants.
void expect_within_caps(const TestBench& board, std::size_t& seen) {
  for (unsigned i = 4; i < 8; ++i) {
    const std::vector<Pulse> pulses = board.hardware.pulses(i);
    seen += pulses.size();
    for (std::size_t k = 0; k < pulses.size(); ++k) {
      ASSERT_LE(pulses[k].width(), kCapStrobeWidth);
      if (k == 0) continue;
      ASSERT_GE((pulses[k].rise - pulses[k - 1].rise) * kCapStrobeDuty_permille,
                pulses[k - 1].width() * 1000);
    }
  }
}

TEST(Safety, ManySingleShotsDoNotMakeALamp) {
  TestBench board;
  board.stage_period_us(12'000, 0, 1);
  board.stage_output(4, 0, 300);
  for (int shot = 0; shot < 200; ++shot) {
    board.start();
    board.run_us(1000);
    board.command(GLINT_SYNC_COMMAND_STOP);
    board.run_us(100);
  }
  std::size_t seen = 0;
  expect_within_caps(board, seen);
  EXPECT_GT(seen, 10u);
}

/// Of an output's pulses, the shortest time from one rise to the next.
std::uint64_t least_interval(const TestBench& board, unsigned output) {
  const std::vector<Pulse> pulses = board.hardware.pulses(output);
  std::uint64_t least = ~std::uint64_t{0};
  for (std::size_t k = 1; k < pulses.size(); ++k)
    least = std::min(least, pulses[k].rise - pulses[k - 1].rise);
  return least;
}

TEST(Safety, EdgesAreNotTakenWhileAStrobeOfTheRunBeforePauses) {
  TestBench board;
  board.run_us(30'000);
  board.stage_period_us(12'000, 0, 1);
  board.stage_output(4, 0, 300);
  ASSERT_TRUE(board.start());
  board.run_us(1500);
  ASSERT_FALSE(board.device.running());
  board.stage_period_us(12'000, GLINT_SYNC_RUN_EXTERNAL);
  ASSERT_TRUE(board.start());
  for (int i = 0; i < 200; ++i) {
    board.run_us(100);
    board.edge();
  }
  EXPECT_GE(board.hardware.pulses(4).size(), 2u);
  EXPECT_GE(least_interval(board, 4), ticks_of_us(12'000));
}

TEST(Safety, EdgesAreNotTakenTooSoonAfterTheDelayOfAStrobeWasShortened) {
  TestBench board;
  board.run_us(30'000);
  board.stage_period_us(12'000, GLINT_SYNC_RUN_EXTERNAL);
  board.stage_output(4, 9000, 300);
  ASSERT_TRUE(board.start());
  board.run_us(100);
  ASSERT_TRUE(board.edge());
  board.stage_output(4, 0, 300);
  ASSERT_TRUE(board.command(GLINT_SYNC_COMMAND_APPLY));
  for (int i = 0; i < 400; ++i) {
    board.run_us(100);
    board.edge();
  }
  EXPECT_GE(board.hardware.pulses(4).size(), 2u);
  EXPECT_GE(least_interval(board, 4), ticks_of_us(12'000));
}

TEST(Safety, StrobesThatTakeTurnsKeepTheRate) {
  TestBench board;
  board.run_us(30'000);
  board.stage_period_us(4000);
  board.stage_output(0, 0, 100);
  board.stage_output(4, 0, 200, 2, 0);
  board.stage_output(5, 0, 200, 2, 1);
  ASSERT_TRUE(board.start());
  board.run_us(50'000);
  const std::vector<Pulse> pulses = board.hardware.pulses(0);
  ASSERT_GE(pulses.size(), 12u);
  for (std::size_t k = 1; k < pulses.size(); ++k)
    EXPECT_EQ(pulses[k].rise - pulses[k - 1].rise, ticks_of_us(4000));
  EXPECT_EQ(least_interval(board, 4), ticks_of_us(8000));
  EXPECT_EQ(board.status().held_strobes, 0u);
}

TEST(Safety, AfterAResetStrobesWaitAsAfterTheLongestPulse) {
  std::uint64_t now = 0;
  NotedPulses hardware(now);
  SyncDevice device(hardware, Identity{{}, 1, 0, false, 0, ""}, now);
  FramePlanner planner(now);
  Plan plan = default_plan();
  plan.outputs[4].flags = GLINT_SYNC_OUTPUT_ENABLED;
  EXPECT_EQ(planner.earliest_frame(plan, 0, 0), ticks_of_us(12'000));
}

/// Hosts gone mad: reports that make sense, nearly make sense, and make none, at any time, with a supply that
/// jumps, edges that come at any time and timers that are late.
void let_a_mad_host_loose(std::uint32_t seed, int reports, std::size_t& seen) {
  std::mt19937 random(seed);
  const auto up_to = [&random](std::uint32_t most) {
    return std::uniform_int_distribution<std::uint32_t>(0, most)(random);
  };
  const auto often = [&](std::uint32_t one_in) { return up_to(one_in - 1) != 0; };
  TestBench board(up_to(1) != 0);
  for (int n = 0; n < reports; ++n) {
    std::array<std::uint8_t, GLINT_SYNC_REPORT_BYTES> bytes{};
    std::size_t size = bytes.size();
    const std::uint32_t kind = up_to(15);
    if (kind < 5) {
      glint_sync_output output{};
      output.report_id = static_cast<std::uint8_t>(GLINT_SYNC_OUTPUT + up_to(7));
      output.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
      output.flags = static_cast<std::uint8_t>(
          often(40) ? (board.get<glint_sync_output>(output.report_id).flags & 2) | up_to(1) : up_to(3));
      output.every_n = static_cast<std::uint8_t>(often(3) ? 1 : 1 + up_to(4));
      output.phase = static_cast<std::uint8_t>(often(10) ? up_to(output.every_n - 1u) : up_to(6));
      output.delay_ticks = ticks_of_us(up_to(often(100) ? 900 : 20'000));
      output.width_ticks =
          often(100) ? ticks_of_us(1) + up_to(ticks_of_us(100)) : up_to(often(2) ? 2 * kCapStrobeWidth : ~0u);
      std::memcpy(bytes.data(), &output, sizeof output);
    } else if (kind < 8) {
      glint_sync_run run{};
      run.report_id = GLINT_SYNC_RUN;
      run.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
      run.flags = static_cast<std::uint8_t>(often(3) ? 0 : up_to(7));
      run.period_ticks = ticks_of_us(often(20) ? 3000 + up_to(15'000) : up_to(11'000'000));
      run.pulses = often(10) ? 0 : up_to(5);
      run.code_group = static_cast<std::uint16_t>(often(20) ? up_to(1) * 18 : up_to(1100));
      run.dark_width_ticks = often(20) ? up_to(1) * ticks_of_us(10) : up_to(~0u);
      run.keepalive_ms = static_cast<std::uint16_t>(often(10) ? 0 : up_to(200));
      std::memcpy(bytes.data(), &run, sizeof run);
    } else if (kind < 14) {
      glint_sync_command command{};
      command.report_id = GLINT_SYNC_COMMAND;
      command.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
      command.command = static_cast<std::uint8_t>(often(3) ? 1 + up_to(2) : up_to(8));
      command.argument = up_to(9);
      std::memcpy(bytes.data(), &command, sizeof command);
    } else if (kind == 14) {
      auto limits = board.get<glint_sync_limits>(GLINT_SYNC_LIMITS);
      limits.strobe_max_duty_permille = static_cast<std::uint16_t>(often(3) ? 25 : up_to(30));
      limits.strobe_max_width_ticks = often(3) ? kCapStrobeWidth : up_to(2 * kCapStrobeWidth);
      limits.lockout_mv = static_cast<std::uint16_t>(13'000 + up_to(1200));
      std::memcpy(bytes.data(), &limits, sizeof limits);
    } else {
      for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(up_to(255));
      size = up_to(static_cast<std::uint32_t>(bytes.size()));
    }
    board.set_bytes(bytes.data(), size);
    if (!often(8)) board.timer_delay = up_to(ticks_of_us(40));
    if (!often(2000)) board.timer_delay = up_to(ticks_of_us(200));
    if (!often(20)) board.supply_mv = static_cast<std::uint16_t>(often(15) ? 12'000 : 13'000 + up_to(2000));
    board.run_us(up_to(often(10) ? 2000 : 30'000));
    // Edges come whenever they like; the first that somebody waits for begins a frame.
    for (int k = 0; k < 8 && !board.edge(); ++k) board.run_us(up_to(400));
    if (n % 1000 == 999) {
      expect_within_caps(board, seen);
      if (::testing::Test::HasFatalFailure()) FAIL() << "seed " << seed << ", report " << n;
      board.hardware.forget_pulses();
      board.take_reports();
    }
  }
}

TEST(Safety, NoSequenceOfReportsBreaksACap) {
  std::size_t seen = 0;
  for (std::uint32_t seed = 0; seed < 40; ++seed) let_a_mad_host_loose(seed, 55'000, seen);
  EXPECT_GT(seen, 100'000u) << "pulses of strobes";
}

}  // namespace
}  // namespace glint::board
