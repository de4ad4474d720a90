// SPDX-License-Identifier: MIT
#include "usb-sync/input_report.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <random>
#include <vector>

namespace glint::sync {
namespace {

glint_sync_input three_triggers() {
  glint_sync_input wire{};
  wire.report_id = GLINT_SYNC_INPUT;
  wire.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  wire.kind = GLINT_SYNC_KIND_TRIGGERS;
  wire.epoch = 77;
  wire.report_no = 5;
  wire.run = 2;
  wire.supply_mv = 12'345;
  wire.tick = 1'000'000'000'000;
  wire.sequence = 40;
  wire.count = 3;
  wire.unsent = 9;
  wire.step_ticks[0] = 125'000;
  wire.step_ticks[1] = 125'008;
  wire.outputs[0] = 0xff;
  wire.outputs[1] = 0x0f;
  wire.outputs[2] = 0x11;
  wire.trigger_flags[1] = GLINT_SYNC_TRIGGER_DARK;
  return wire;
}

std::vector<std::uint8_t> bytes_of(const glint_sync_input& wire) {
  const auto* bytes = reinterpret_cast<const std::uint8_t*>(&wire);
  return {bytes, bytes + sizeof wire};
}

Flaw flaw_of(const glint_sync_input& wire, std::uint8_t id = GLINT_SYNC_INPUT) {
  return parse_input(bytes_of(wire), id).flaw;
}

TEST(InputReport, TellsOfEachTrigger) {
  const ParsedReport parsed = parse_input(bytes_of(three_triggers()), GLINT_SYNC_INPUT);
  ASSERT_EQ(parsed.flaw, Flaw::None);
  EXPECT_EQ(parsed.report.epoch, 77u);
  EXPECT_EQ(parsed.report.report_no, 5u);
  EXPECT_EQ(parsed.report.run, 2u);
  EXPECT_EQ(parsed.report.supply_mv, 12'345u);
  EXPECT_EQ(parsed.report.unsent, 9u);
  const auto& triggers = std::get<Triggers>(parsed.report.content);
  ASSERT_EQ(triggers.all().size(), 3u);
  EXPECT_EQ(triggers.list[0], (Trigger{1'000'000'000'000, 40, 0xff, 0}));
  EXPECT_EQ(triggers.list[1], (Trigger{1'000'000'125'000, 41, 0x0f, GLINT_SYNC_TRIGGER_DARK}));
  EXPECT_EQ(triggers.list[2], (Trigger{1'000'000'250'008, 42, 0x11, 0}));
  EXPECT_TRUE(triggers.list[1].dark());
  EXPECT_FALSE(triggers.list[2].dark());
  EXPECT_EQ(parsed.report.sent_after(), 1'000'000'250'008u);
}

TEST(InputReport, TellsOfEvents) {
  glint_sync_input wire = three_triggers();
  wire.kind = GLINT_SYNC_KIND_STOPPED;
  wire.count = 0;
  wire.detail = GLINT_SYNC_STOP_FAULT | GLINT_SYNC_FAULT_STALLED << 8;
  const ParsedReport parsed = parse_input(bytes_of(wire), GLINT_SYNC_INPUT);
  ASSERT_EQ(parsed.flaw, Flaw::None);
  const auto& event = std::get<Event>(parsed.report.content);
  EXPECT_EQ(event.kind, Event::Kind::Stopped);
  EXPECT_EQ(event.sequence, 40u);
  EXPECT_EQ(event.stop_reason(), std::uint32_t{GLINT_SYNC_STOP_FAULT});
  EXPECT_EQ(event.fault(), std::uint32_t{GLINT_SYNC_FAULT_STALLED});
}

TEST(InputReport, AnEventDoesNotSayWhenItWasSent) {
  glint_sync_input wire = three_triggers();
  wire.kind = GLINT_SYNC_KIND_STARTED;  // its tick is that of a frame to come
  wire.count = 0;
  EXPECT_EQ(parse_input(bytes_of(wire), GLINT_SYNC_INPUT).report.sent_after(), std::nullopt);
}

TEST(InputReport, KindsOfNewerFirmwareAreEventsWithoutName) {
  glint_sync_input wire = three_triggers();
  wire.kind = 42;
  wire.count = 0;
  const ParsedReport parsed = parse_input(bytes_of(wire), GLINT_SYNC_INPUT);
  ASSERT_EQ(parsed.flaw, Flaw::None);
  EXPECT_EQ(std::get<Event>(parsed.report.content).kind, Event::Kind::Unknown);
}

TEST(InputReport, EveryOtherLengthIsRefused) {
  const std::vector<std::uint8_t> whole = bytes_of(three_triggers());
  for (std::size_t length = 0; length <= 4096; ++length) {
    std::vector<std::uint8_t> bytes = whole;
    bytes.resize(length, 0x5a);
    const Flaw expected = length == GLINT_SYNC_REPORT_BYTES ? Flaw::None : Flaw::Length;
    EXPECT_EQ(parse_input(bytes, GLINT_SYNC_INPUT).flaw, expected) << length;
  }
}

TEST(InputReport, OtherIdsAndProtocolsAreRefused) {
  for (int value = 0; value < 256; ++value) {
    glint_sync_input wire = three_triggers();
    wire.report_id = static_cast<std::uint8_t>(value);
    EXPECT_EQ(flaw_of(wire), value == GLINT_SYNC_INPUT ? Flaw::None : Flaw::ReportId);
    wire = three_triggers();
    wire.protocol = static_cast<std::uint8_t>(value);
    EXPECT_EQ(flaw_of(wire), value == GLINT_SYNC_PROTOCOL_MAJOR ? Flaw::None : Flaw::Protocol);
  }
}

TEST(InputReport, NonsenseCountsAreRefused) {
  for (int count = 0; count < 256; ++count) {
    glint_sync_input wire = three_triggers();
    wire.step_ticks[2] = 1;
    wire.count = static_cast<std::uint8_t>(count);
    EXPECT_EQ(flaw_of(wire), count >= 1 && count <= 4 ? Flaw::None : Flaw::Count);
    wire.kind = GLINT_SYNC_KIND_BOOTED;
    EXPECT_EQ(flaw_of(wire), count == 0 ? Flaw::None : Flaw::Count);
  }
}

TEST(InputReport, TriggersThatDoNotFollowEachOtherAreRefused) {
  glint_sync_input wire = three_triggers();
  wire.step_ticks[1] = 0;
  EXPECT_EQ(flaw_of(wire), Flaw::Tick);
  wire = three_triggers();
  wire.tick = std::numeric_limits<std::uint64_t>::max() - 130'000;  // the third is beyond the end of time
  EXPECT_EQ(flaw_of(wire), Flaw::Tick);
}

TEST(InputReport, AnAnswerIsTakenOnlyWhereOneWasAskedFor) {
  glint_sync_input wire = three_triggers();
  wire.kind = GLINT_SYNC_KIND_GONE;
  wire.count = 0;
  wire.report_no = 1234;
  EXPECT_EQ(flaw_of(wire), Flaw::Kind);
  wire.report_id = GLINT_SYNC_FETCH;
  const ParsedReport parsed = parse_input(bytes_of(wire), GLINT_SYNC_FETCH);
  ASSERT_EQ(parsed.flaw, Flaw::None);
  EXPECT_EQ(std::get<NotHeld>(parsed.report.content).oldest_held, 1234u);
}

TEST(InputReport, NoBytesAtAllBreakIt) {
  std::mt19937 random(2);
  std::size_t taken = 0;
  for (int i = 0; i < 200'000; ++i) {
    std::vector<std::uint8_t> bytes = bytes_of(three_triggers());
    if (i % 3 == 0) bytes.resize(random() % 130);
    const std::size_t changes = i % 2 == 0 ? random() % 6 : bytes.size();
    for (std::size_t c = 0; c < changes && !bytes.empty(); ++c) {
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    }
    const ParsedReport parsed = parse_input(bytes, i % 5 == 0 ? GLINT_SYNC_FETCH : GLINT_SYNC_INPUT);
    EXPECT_NE(flaw_text(parsed.flaw), nullptr);
    if (parsed.flaw != Flaw::None) continue;
    ++taken;
    ASSERT_EQ(bytes.size(), std::size_t{GLINT_SYNC_REPORT_BYTES});
    if (const auto* triggers = std::get_if<Triggers>(&parsed.report.content)) {
      ASSERT_GE(triggers->count, 1u);
      ASSERT_LE(triggers->count, 4u);
      for (std::size_t t = 1; t < triggers->count; ++t) {
        ASSERT_GT(triggers->list[t].tick, triggers->list[t - 1].tick);
      }
    }
  }
  EXPECT_GT(taken, 1000u);
}

}  // namespace
}  // namespace glint::sync
