// SPDX-License-Identifier: MIT
#include "usb-sync/board_plan.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::uint32_t kTickHz = 125'000'000;

std::string error_of(const BoardPlan& plan) {
  try {
    to_reports(plan, kTickHz);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(BoardPlan, EachTimeBecomesTheNearestTick) {
  BoardPlan plan;
  plan.period = Seconds(1.0 / 90.0);
  plan.outputs[4] = {.enabled = true, .delay = 788us, .width = 137us};
  plan.code = {.seed = 7, .group = 30, .dark_width = 13ns};
  const PlanReports reports = to_reports(plan, kTickHz);
  EXPECT_EQ(reports.run.period_ticks, 1'388'889u);
  EXPECT_EQ(reports.outputs[4].delay_ticks, 98'500u);
  EXPECT_EQ(reports.outputs[4].width_ticks, 17'125u);
  EXPECT_EQ(reports.run.dark_width_ticks, 2u);
}

TEST(BoardPlan, SaysWhatWasReallySet) {
  BoardPlan plan;
  plan.period = Seconds(1.0 / 90.0);
  const BoardPlan real = on_grid(plan, kTickHz);
  EXPECT_DOUBLE_EQ(real.period.count(), 1'388'889 * 8e-9);
  EXPECT_EQ(on_grid(real, kTickHz), real);  // what is on the grid stays
}

TEST(BoardPlan, EveryReportNamesItselfAndItsProtocol) {
  const PlanReports reports = to_reports({}, kTickHz);
  EXPECT_EQ(reports.run.report_id, GLINT_SYNC_RUN);
  EXPECT_EQ(reports.run.protocol, GLINT_SYNC_PROTOCOL_MAJOR);
  for (std::size_t i = 0; i < kOutputs; ++i) {
    EXPECT_EQ(reports.outputs[i].report_id, GLINT_SYNC_OUTPUT + i);
    EXPECT_EQ(reports.outputs[i].protocol, GLINT_SYNC_PROTOCOL_MAJOR);
  }
}

TEST(BoardPlan, NothingIsLostOnTheWayToThePlanAndBack) {
  std::mt19937 random(1);
  for (int i = 0; i < 2000; ++i) {
    const std::uint32_t tick_hz = i % 2 == 0 ? kTickHz : 133'000'000;
    PlanReports sent = to_reports({}, tick_hz);
    sent.run.flags = static_cast<std::uint8_t>(random() % 8);
    if ((sent.run.flags & GLINT_SYNC_RUN_EXTERNAL) == 0) sent.run.flags &= GLINT_SYNC_RUN_SYNC_OUT;
    sent.run.period_ticks = static_cast<std::uint32_t>(random());
    sent.run.pulses = static_cast<std::uint32_t>(random());
    sent.run.code_seed = static_cast<std::uint32_t>(random());
    sent.run.code_group = static_cast<std::uint16_t>(random());
    sent.run.keepalive_ms = static_cast<std::uint16_t>(random());
    sent.run.dark_width_ticks = static_cast<std::uint32_t>(random());
    for (glint_sync_output& output : sent.outputs) {
      output.flags = static_cast<std::uint8_t>(random() % 4);
      output.every_n = static_cast<std::uint8_t>(random());
      output.phase = static_cast<std::uint8_t>(random());
      output.delay_ticks = static_cast<std::uint32_t>(random());
      output.width_ticks = static_cast<std::uint32_t>(random());
    }
    const PlanReports back = to_reports(from_reports(sent, tick_hz), tick_hz);
    EXPECT_EQ(std::memcmp(&back, &sent, sizeof sent), 0);
  }
}

TEST(BoardPlan, ExternalStartsKeepTheirEdge) {
  for (const FrameStart start : {FrameStart::Internal, FrameStart::RisingEdge, FrameStart::FallingEdge}) {
    BoardPlan plan;
    plan.start = start;
    EXPECT_EQ(on_grid(plan, kTickHz).start, start);
  }
}

TEST(BoardPlan, WhatCannotBeSaidIsAnErrorWithItsName) {
  BoardPlan plan;
  plan.outputs[5].width = -3us;
  EXPECT_THAT(error_of(plan), HasSubstr("output 5 (strobe): width is -3 us"));
  plan = {};
  plan.outputs[1].delay = 40s;
  EXPECT_THAT(error_of(plan), HasSubstr("output 1 (trigger): delay is 40 s"));
  plan = {};
  plan.period = Seconds(std::numeric_limits<double>::quiet_NaN());
  EXPECT_THAT(error_of(plan), HasSubstr("the period is nan"));
  plan = {};
  plan.outputs[0].every_n = 256;
  EXPECT_THAT(error_of(plan), HasSubstr("output 0 (trigger): every_n is 256"));
  plan = {};
  plan.keepalive = 2min;
  EXPECT_THAT(error_of(plan), HasSubstr("keep-alive time in ms is 120000"));
  plan = {};
  plan.code.group = -1;
  EXPECT_THAT(error_of(plan), HasSubstr("group of the dark code is -1"));
}

TEST(TimeText, ReadsAsAPersonWouldWriteIt) {
  EXPECT_EQ(time_text(0s), "0 s");
  EXPECT_EQ(time_text(8ns), "8 ns");
  EXPECT_EQ(time_text(300us), "300 us");
  EXPECT_EQ(time_text(Seconds(37'500 / 125e6)), "300 us");
  EXPECT_EQ(time_text(Seconds(1.0 / 90.0)), "11.1111 ms");
  EXPECT_EQ(time_text(10s), "10 s");
  EXPECT_EQ(time_text(-3us), "-3 us");
}

}  // namespace
}  // namespace glint::sync
