// SPDX-License-Identifier: MIT
// Frames that begin with edges at sync in.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/firmware/test_bench.hpp"

namespace glint::board {
namespace {

class ExternalRun : public ::testing::Test {
 protected:
  void start(std::uint32_t pulses = 0) {
    board.stage_period_us(5000, GLINT_SYNC_RUN_EXTERNAL, pulses);
    board.stage_output(0, 10, 1000);
    board.stage_output(4, 788, 100);
    ASSERT_TRUE(board.start());
    board.run_us(100);
  }
  TestBench board;
};

TEST_F(ExternalRun, EachEdgeFiresOnce) {
  start();
  EXPECT_EQ(board.status().state, GLINT_SYNC_WAITING);
  std::vector<std::uint64_t> edges;
  for (unsigned i = 0; i < 20; ++i) {
    board.run_us(5100 + 777 * i);
    edges.push_back(board.now);
    ASSERT_TRUE(board.edge());
  }
  board.run_us(6000);
  const auto pulses = board.hardware.pulses(0), strobes = board.hardware.pulses(4);
  ASSERT_EQ(pulses.size(), edges.size());
  ASSERT_EQ(strobes.size(), edges.size());
  const auto triggers = TestBench::triggers_in(board.take_reports());
  ASSERT_EQ(triggers.size(), edges.size());
  for (std::size_t i = 0; i < edges.size(); ++i) {
    EXPECT_EQ(pulses[i].rise, edges[i] + ticks_of_us(10));
    EXPECT_EQ(strobes[i].rise, edges[i] + ticks_of_us(788));
    EXPECT_EQ(triggers[i].tick, edges[i]);
    EXPECT_EQ(triggers[i].sequence, i);
    EXPECT_EQ(triggers[i].flags, GLINT_SYNC_TRIGGER_EXTERNAL);
  }
}

TEST_F(ExternalRun, EdgesThatComeTooSoonAreIgnoredAndCounted) {
  start();
  board.run_us(5000);
  EXPECT_TRUE(board.edge());
  board.run_us(2000);
  EXPECT_FALSE(board.edge());
  board.run_us(4000);
  EXPECT_TRUE(board.edge());
  board.run_us(6000);
  EXPECT_EQ(board.hardware.pulses(0).size(), 2u);
  EXPECT_EQ(board.status().ignored_edges, 1u);
}

TEST_F(ExternalRun, ALevelThatStaysDoesNotFireAgain) {
  start();
  board.run_us(5000);
  EXPECT_TRUE(board.edge());
  board.hardware.sync_in_high = true;
  board.run_us(50'000);
  EXPECT_FALSE(board.edge());
  board.hardware.sync_in_high = false;
  board.run_us(1000);
  EXPECT_TRUE(board.edge());
}

TEST_F(ExternalRun, BurstsCountEdges) {
  start(3);
  for (int i = 0; i < 5; ++i) {
    board.run_us(6000);
    EXPECT_EQ(board.edge(), i < 3);
  }
  board.run_us(20'000);
  EXPECT_EQ(board.hardware.pulses(0).size(), 3u);
  EXPECT_EQ(board.status().stop_reason, GLINT_SYNC_STOP_BURST_END);
  EXPECT_FALSE(board.device.running());
}

TEST_F(ExternalRun, StopWhileWaitingEndsTheRun) {
  start();
  board.run_us(50'000);
  board.take_reports();
  board.command(GLINT_SYNC_COMMAND_STOP);
  board.run_us(100);
  EXPECT_FALSE(board.device.running());
  EXPECT_FALSE(board.edge());
  const auto reports = board.take_reports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].kind, GLINT_SYNC_KIND_STOPPED);
  EXPECT_EQ(reports[0].sequence, 0u);
  EXPECT_GE(reports[0].tick, board.now - ticks_of_us(200));
}

TEST_F(ExternalRun, StopAmidAFrameLetsItsPulsesEnd) {
  start();
  board.run_us(5000);
  ASSERT_TRUE(board.edge());
  board.run_us(800);
  board.command(GLINT_SYNC_COMMAND_STOP);
  board.run_us(5000);
  EXPECT_FALSE(board.device.running());
  ASSERT_EQ(board.hardware.pulses(0).size(), 1u);
  EXPECT_EQ(board.hardware.pulses(0)[0].width(), ticks_of_us(1000));
  EXPECT_EQ(board.status().sequence, 1u);
}

TEST_F(ExternalRun, NewSettingsHoldFromTheNextFrameThatIsArmed) {
  start();
  board.run_us(6000);
  board.edge();
  board.stage_output(0, 20, 500);
  ASSERT_TRUE(board.command(GLINT_SYNC_COMMAND_APPLY));
  board.run_us(6000);
  const std::uint64_t edge = board.now;
  board.edge();
  board.run_us(6000);
  const auto pulses = board.hardware.pulses(0);
  EXPECT_EQ(pulses[1].rise, edge + ticks_of_us(20));
  EXPECT_EQ(pulses[1].width(), ticks_of_us(500));
}

TEST_F(ExternalRun, WhatBeginsFramesIsNotChangedWhileRunning) {
  start();
  board.stage_period_us(5000, 0);
  EXPECT_FALSE(board.command(GLINT_SYNC_COMMAND_APPLY));
  EXPECT_EQ(board.status().refusal, GLINT_SYNC_REFUSED_STATE);
}

}  // namespace
}  // namespace glint::board
