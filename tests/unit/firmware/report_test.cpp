// SPDX-License-Identifier: MIT
// Reports: numbered, held, fetched; settings that come in any shape.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>

#include "tests/unit/firmware/test_bench.hpp"

namespace glint::board {
namespace {

void run_at_2_khz(TestBench& board) {
  board.stage_period_us(500);
  board.stage_output(0, 0, 100);
  ASSERT_TRUE(board.start());
}

TEST(Reports, TheFirstOfAnEpochTellsWhyItBegan) {
  TestBench board(false, GLINT_SYNC_RESET_WATCHDOG);
  const auto reports = board.take_reports();
  ASSERT_EQ(reports.size(), 1u);
  EXPECT_EQ(reports[0].kind, GLINT_SYNC_KIND_BOOTED);
  EXPECT_EQ(reports[0].report_no, 0u);
  EXPECT_EQ(reports[0].epoch, 0xabcdu);
  EXPECT_EQ(reports[0].detail, unsigned{GLINT_SYNC_RESET_WATCHDOG});
  EXPECT_EQ(reports[0].flags, GLINT_SYNC_FLAG_WATCHDOG);
}

TEST(Reports, TriggersArePackedWhenTheHostIsSlowerThanThey) {
  TestBench board;
  board.take_reports();
  run_at_2_khz(board);
  board.run_us(1000);
  std::vector<glint_sync_input> reports;
  for (int ms = 0; ms < 500; ++ms) {
    board.run_us(1000);
    if (const glint_sync_input* report = board.device.take_report()) reports.push_back(*report);
  }
  const auto triggers = TestBench::triggers_in(reports);
  EXPECT_GE(triggers.size(), 995u);
  for (std::size_t i = 1; i < triggers.size(); ++i) {
    EXPECT_EQ(triggers[i].sequence, i);
    EXPECT_EQ(triggers[i].tick - triggers[i - 1].tick, ticks_of_us(500));
  }
  for (std::size_t i = 1; i < reports.size(); ++i)
    EXPECT_EQ(reports[i].report_no, reports[i - 1].report_no + 1);
  EXPECT_EQ(board.status().unsent, 0u);
}

TEST(Reports, WhoBeginsToReadGetsFreshOnesAndCanFetchTheRest) {
  TestBench board;
  run_at_2_khz(board);
  board.run_us(200'000);  // 400 triggers, four in a report; nobody reads
  const std::uint32_t next = board.status().next_report_no;
  EXPECT_GT(next, 90u);
  EXPECT_EQ(board.status().unsent, next - ReportLog::kMostWaiting);
  const auto fresh = board.take_reports();
  ASSERT_EQ(fresh.size(), ReportLog::kMostWaiting);
  EXPECT_EQ(fresh[0].unsent, next - ReportLog::kMostWaiting);
  EXPECT_EQ(fresh[0].queued, ReportLog::kMostWaiting - 1);
  std::uint32_t sequence = 0;
  for (std::uint32_t number = 2; number < fresh[0].report_no; ++number) {
    glint_sync_fetch fetch{};
    fetch.report_no = number;
    ASSERT_TRUE(board.set(GLINT_SYNC_FETCH, fetch));
    const auto fetched = board.get<glint_sync_input>(GLINT_SYNC_FETCH);
    EXPECT_EQ(fetched.report_id, GLINT_SYNC_FETCH);
    ASSERT_EQ(fetched.kind, GLINT_SYNC_KIND_TRIGGERS);
    EXPECT_EQ(fetched.report_no, number);
    EXPECT_EQ(fetched.sequence, sequence);
    sequence += fetched.count;
  }
  EXPECT_EQ(fresh[0].sequence, sequence);
}

TEST(Reports, WhatIsNoLongerOrNotYetHeldIsGone) {
  TestBench board;
  run_at_2_khz(board);
  board.run_us(3'000'000);
  const std::uint32_t next = board.status().next_report_no;
  ASSERT_GT(next, ReportLog::kHeld);
  for (const std::uint32_t number : {0u, next - ReportLog::kHeld - 1, next - 1, next, ~0u}) {
    glint_sync_fetch fetch{};
    fetch.report_no = number;
    board.set(GLINT_SYNC_FETCH, fetch);
    const auto gone = board.get<glint_sync_input>(GLINT_SYNC_FETCH);
    EXPECT_EQ(gone.kind, GLINT_SYNC_KIND_GONE) << number;
    EXPECT_EQ(gone.report_no, next - ReportLog::kHeld);
  }
}

TEST(Reports, AnotherLengthOrProtocolIsRefused) {
  TestBench board;
  glint_sync_command stop{};
  stop.report_id = GLINT_SYNC_COMMAND;
  stop.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  EXPECT_TRUE(board.set_bytes(&stop, sizeof stop));
  for (const std::size_t size : {std::size_t{0}, std::size_t{1}, sizeof stop - 1}) {
    EXPECT_FALSE(board.set_bytes(&stop, size));
    EXPECT_EQ(board.status().refusal, GLINT_SYNC_REFUSED_FORMAT);
  }
  stop.protocol = GLINT_SYNC_PROTOCOL_MAJOR + 1;
  EXPECT_FALSE(board.set_bytes(&stop, sizeof stop));
}

TEST(Reports, WhatCannotBeSetIsRefused) {
  TestBench board;
  for (unsigned id = 0; id < 256; ++id) {
    const bool settable = id == GLINT_SYNC_RUN || id == GLINT_SYNC_COMMAND || id == GLINT_SYNC_FETCH ||
                          (id >= GLINT_SYNC_OUTPUT && id < GLINT_SYNC_OUTPUT + GLINT_SYNC_OUTPUTS);
    if (id == GLINT_SYNC_LIMITS) continue;  // zeros are no limits
    EXPECT_EQ(board.set(static_cast<std::uint8_t>(id), glint_sync_status{}), settable) << id;
  }
}

TEST(Reports, WhatIsSetCanBeRead) {
  TestBench board;
  glint_sync_output output{};
  output.delay_ticks = 98'500;
  output.every_n = 2;
  board.set(GLINT_SYNC_OUTPUT + 6, output);
  const auto read = board.get<glint_sync_output>(GLINT_SYNC_OUTPUT + 6);
  EXPECT_EQ(read.report_id, GLINT_SYNC_OUTPUT + 6);
  EXPECT_EQ(read.delay_ticks, 98'500u);
  EXPECT_EQ(read.every_n, 2);
}

TEST(Reports, InfoTellsWhoTheBoardIs) {
  TestBench board(true);
  const auto info = board.get<glint_sync_info>(GLINT_SYNC_INFO);
  EXPECT_EQ(info.protocol, GLINT_SYNC_PROTOCOL_MAJOR);
  EXPECT_EQ(info.tick_hz, 125'000'000u);
  EXPECT_EQ(info.outputs, 8);
  EXPECT_EQ(info.strobes_active_low, 1);
  EXPECT_EQ(info.firmware_version, 0x000100u);
  EXPECT_STREQ(info.build, "abcdef");
  EXPECT_EQ(info.serial[7], 8);
}

TEST(Reports, TimeIsWhenTheRequestArrived) {
  TestBench board;
  glint_sync_time time{};
  for (std::uint32_t i = 1; i < 4; ++i) {
    ASSERT_TRUE(board.device.get_report(GLINT_SYNC_TIME, reinterpret_cast<std::uint8_t*>(&time), 1234 * i,
                                        board.now));
    EXPECT_EQ(time.tick, 1234 * i);
    EXPECT_EQ(time.queries, i);
  }
}

TEST(Reports, FetchingDoesNotHideARefusal) {
  TestBench board;
  EXPECT_FALSE(board.start());
  board.set(GLINT_SYNC_FETCH, glint_sync_fetch{});
  EXPECT_EQ(board.status().refusal, GLINT_SYNC_REFUSED_NO_OUTPUT);
  board.command(GLINT_SYNC_COMMAND_KEEP_ALIVE);
  EXPECT_EQ(board.status().refusal, GLINT_SYNC_REFUSED_NOTHING);
}

TEST(Reports, ASelfTestIsNoRun) {
  TestBench board;
  board.stage_period_us(2000, 0, 7);
  board.stage_output(0, 0, 100);
  board.start();
  board.run_us(50'000);
  board.command(GLINT_SYNC_COMMAND_SELFTEST, 1);
  board.run_us(500'000);
  EXPECT_EQ(board.status().run, 1);
  EXPECT_EQ(board.status().sequence, 7u);
  EXPECT_EQ(board.status().stop_reason, GLINT_SYNC_STOP_BURST_END);
}

TEST(Reports, ResetAndBootloaderWantTheirNumber) {
  TestBench board;
  EXPECT_FALSE(board.command(GLINT_SYNC_COMMAND_RESET, 1));
  EXPECT_FALSE(board.command(GLINT_SYNC_COMMAND_BOOTLOADER, GLINT_SYNC_MAGIC_RESET));
  EXPECT_EQ(board.request, Request::None);
  EXPECT_TRUE(board.command(GLINT_SYNC_COMMAND_RESET, GLINT_SYNC_MAGIC_RESET));
  EXPECT_EQ(board.request, Request::Reset);
  EXPECT_TRUE(board.command(GLINT_SYNC_COMMAND_BOOTLOADER, GLINT_SYNC_MAGIC_BOOTLOADER));
  EXPECT_EQ(board.request, Request::Bootloader);
}

}  // namespace
}  // namespace glint::board
