// SPDX-License-Identifier: MIT
#include "usb-sync/board_state.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include "usb-sync/board_text.hpp"
#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::uint32_t kTickHz = 125'000'000;

template <class Wire>
Wire wire(std::uint8_t id) {
  Wire report{};
  report.report_id = id;
  report.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  return report;
}

template <class Wire>
std::vector<std::uint8_t> bytes_of(const Wire& report) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&report);
  return {bytes, bytes + sizeof report};
}

glint_sync_info good_info() {
  auto info = wire<glint_sync_info>(GLINT_SYNC_INFO);
  info.tick_hz = kTickHz;
  info.firmware_version = 0x010203;
  info.epoch = 5;
  const std::uint8_t serial[8] = {0xe6, 0x61, 0x4c, 0x31, 0x1b, 0x00, 0xab, 0xff};
  std::memcpy(info.serial, serial, sizeof serial);
  std::memcpy(info.build, "abc1234", 7);
  return info;
}

TEST(Info, SaysWhoTheBoardIs) {
  const auto info = parse_info(bytes_of(good_info()));
  ASSERT_TRUE(info);
  EXPECT_EQ(info->firmware_text(), "1.2.3");
  EXPECT_EQ(info->serial, "E6614C311B00ABFF");
  EXPECT_EQ(info->build, "abc1234");
  EXPECT_EQ(info->epoch, 5u);
}

TEST(Info, WithoutATickRateItIsNonsense) {
  glint_sync_info info = good_info();
  info.tick_hz = 0;
  EXPECT_FALSE(parse_info(bytes_of(info)));
}

TEST(Info, ANameWithoutEndOrWithControlCharactersIsHarmless) {
  glint_sync_info info = good_info();
  std::memset(info.build, 'x', sizeof info.build);
  EXPECT_EQ(parse_info(bytes_of(info))->build, std::string(24, 'x'));
  std::memcpy(info.build, "a\x1b[2Jb\"\xff", 9);
  info.build[9] = 0;
  EXPECT_EQ(parse_info(bytes_of(info))->build, "a[2Jb\"");
}

TEST(BoardState, OtherLengthsIdsAndProtocolsAreRefused) {
  const std::vector<std::uint8_t> whole = bytes_of(wire<glint_sync_status>(GLINT_SYNC_STATUS));
  EXPECT_TRUE(parse_status(whole));
  for (std::size_t length = 0; length < 100; ++length) {
    std::vector<std::uint8_t> bytes = whole;
    bytes.resize(length);
    EXPECT_EQ(parse_status(bytes).has_value(), length == whole.size());
  }
  std::vector<std::uint8_t> bytes = whole;
  bytes[0] = GLINT_SYNC_INFO;
  EXPECT_FALSE(parse_status(bytes));
  bytes = whole;
  bytes[1] = GLINT_SYNC_PROTOCOL_MAJOR + 1;
  EXPECT_FALSE(parse_status(bytes));
}

TEST(BoardState, StatesWithoutMeaningAreRefused) {
  auto status = wire<glint_sync_status>(GLINT_SYNC_STATUS);
  status.state = GLINT_SYNC_TESTING + 1;
  EXPECT_FALSE(parse_status(bytes_of(status)));
  auto test = wire<glint_sync_selftest>(GLINT_SYNC_SELFTEST);
  test.state = GLINT_SYNC_SELFTEST_DONE + 1;
  EXPECT_FALSE(parse_selftest(bytes_of(test), kTickHz));
  test.state = GLINT_SYNC_SELFTEST_DONE;
  test.output = 8;
  EXPECT_FALSE(parse_selftest(bytes_of(test), kTickHz));
}

TEST(BoardState, NoBytesAtAllBreakTheParsers) {
  std::mt19937 random(4);
  for (int i = 0; i < 20'000; ++i) {
    std::vector<std::uint8_t> bytes(GLINT_SYNC_REPORT_BYTES);
    for (std::uint8_t& byte : bytes) byte = static_cast<std::uint8_t>(random());
    bytes[1] = GLINT_SYNC_PROTOCOL_MAJOR;
    bytes[0] = GLINT_SYNC_STATUS;
    if (const auto status = parse_status(bytes)) {
      EXPECT_FALSE(refusal_text(*status, kTickHz).empty());
      EXPECT_FALSE(fault_text(status->fault).empty());
      EXPECT_FALSE(stop_text(status->stop_reason).empty());
      EXPECT_FALSE(reset_text(status->reset_reason).empty());
    }
    bytes[0] = GLINT_SYNC_INFO;
    (void)parse_info(bytes);
    bytes[0] = GLINT_SYNC_LIMITS;
    EXPECT_TRUE(parse_limits(bytes, kTickHz));
    bytes[0] = GLINT_SYNC_SELFTEST;
    if (const auto result = parse_selftest(bytes, kTickHz)) (void)result->passed();
  }
}

TEST(BoardLimits, GoThereAndBack) {
  Limits limits;
  limits.lockout_v = 13.5;
  limits.rearm_v = 13.25;
  limits.strobe_max_duty = 0.02;
  limits.strobe_max_width = 250us;
  const glint_sync_limits report = to_report(limits, kTickHz);
  EXPECT_EQ(report.lockout_mv, 13'500u);
  EXPECT_EQ(report.rearm_mv, 13'250u);
  EXPECT_EQ(report.strobe_max_duty_permille, 20u);
  EXPECT_EQ(report.strobe_max_width_ticks, 31'250u);
  const auto back = parse_limits(bytes_of(report), kTickHz);
  ASSERT_TRUE(back);
  EXPECT_DOUBLE_EQ(back->lockout_v, 13.5);
  EXPECT_DOUBLE_EQ(back->strobe_max_duty, 0.02);
  EXPECT_DOUBLE_EQ(back->strobe_max_width.count(), 250e-6);
}

TEST(BoardLimits, WhatCannotBeSaidIsAnError) {
  for (const double volts : {-1.0, 70.0, std::nan("")}) {
    Limits limits;
    limits.lockout_v = volts;
    EXPECT_THROW(to_report(limits, kTickHz), Error);
  }
}

SelfTestResult good_test() {
  SelfTestResult result;
  result.state = SelfTestResult::State::Done;
  result.sent = result.seen = 32;
  result.resolution = 16ns;
  result.width = result.least_width = 137us;
  result.most_width = 137us + 16ns;
  result.period = result.least_period = 10ms;
  result.most_period = 10ms + 32ns;
  return result;
}

TEST(SelfTest, PassesOnlyIfAllIsRight) {
  EXPECT_TRUE(good_test().passed());
  const auto fails = [](auto&& damage) {
    SelfTestResult result = good_test();
    damage(result);
    return !result.passed();
  };
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.state = SelfTestResult::State::Running; }));
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.seen = 0; }));
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.seen = 33; }));
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.sent = r.seen = 0; }));
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.least_width -= 24ns; }));
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.most_width += 8ns; }));
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.least_period -= 40ns; }));
  EXPECT_TRUE(fails([](SelfTestResult& r) { r.most_period += 8ns; }));
}

TEST(RefusalText, NamesOutputLimitAndUnit) {
  Status status;
  status.refusal_output = 5;
  const auto text = [&](std::uint8_t refusal, std::uint32_t limit) {
    status.refusal = refusal;
    status.refusal_limit = limit;
    return refusal_text(status, kTickHz);
  };
  EXPECT_EQ(text(GLINT_SYNC_REFUSED_STROBE_WIDTH, 37'500),
            "output 5 (strobe): the light may be on for at most 300 us");
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_STROBE_DUTY, 25), HasSubstr("at most 2.5 % of the time"));
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_POLARITY, 1), HasSubstr("makes strobes active low"));
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_PHASE, 3), HasSubstr("below every_n, 3"));
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_DELAY, 1'388'889), HasSubstr("below the period, 11.1111 ms"));
  status.refusal_output = 2;
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_POLARITY, 0), HasSubstr("cannot change during a run"));
  status.refusal_output.reset();
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_PERIOD_SHORT, 62'500), HasSubstr("500 us (2000 Hz) at least"));
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_WIDTH_SHORT, 125), HasSubstr("dark frames: the pulse is too short"));
  status.supply_v = 14.21;
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_SUPPLY, 0), HasSubstr("14.21 V"));
  status.state = RunState::Idle;
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_STATE, 0), HasSubstr("start a run first"));
  status.state = RunState::Running;
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_STATE, 0), HasSubstr("stop it first"));
  status.fault = GLINT_SYNC_FAULT_SUPPLY;
  EXPECT_THAT(text(GLINT_SYNC_REFUSED_FAULT, 3), HasSubstr("the supply of the lights cannot be measured"));
  EXPECT_THAT(text(200, 0), HasSubstr("older than the board's firmware"));
}

}  // namespace
}  // namespace glint::sync
