// SPDX-License-Identifier: MIT
#include "usb-sync/input_report.hpp"

#include <cstring>
#include <limits>

namespace glint::sync {
namespace {

Flaw read_triggers(const glint_sync_input& wire, Triggers& triggers) noexcept {
  if (wire.count == 0 || wire.count > GLINT_SYNC_TRIGGERS_PER_REPORT) return Flaw::Count;
  triggers.count = wire.count;
  std::uint64_t tick = wire.tick;
  for (std::size_t i = 0; i < wire.count; ++i) {
    if (i > 0) {
      const std::uint32_t step = wire.step_ticks[i - 1];
      if (step == 0 || tick > std::numeric_limits<std::uint64_t>::max() - step) return Flaw::Tick;
      tick += step;
    }
    triggers.list[i] = {.tick = tick,
                        .sequence = wire.sequence + static_cast<std::uint32_t>(i),
                        .outputs = wire.outputs[i],
                        .flags = wire.trigger_flags[i]};
  }
  return Flaw::None;
}

Event::Kind event_kind(std::uint8_t kind) noexcept {
  const bool known = kind >= GLINT_SYNC_KIND_BOOTED && kind <= GLINT_SYNC_KIND_REARMED;
  return known ? static_cast<Event::Kind>(kind) : Event::Kind::Unknown;
}

}  // namespace

std::optional<std::uint64_t> InputReport::sent_after() const noexcept {
  const auto* triggers = std::get_if<Triggers>(&content);
  if (triggers == nullptr || triggers->count == 0) return std::nullopt;
  return triggers->list[triggers->count - 1u].tick;
}

const char* flaw_text(Flaw flaw) noexcept {
  switch (flaw) {
    case Flaw::None:
      return "nothing is wrong";
    case Flaw::Length:
      return "wrong length";
    case Flaw::ReportId:
      return "wrong report id";
    case Flaw::Protocol:
      return "another major protocol";
    case Flaw::Kind:
      return "an answer that was not asked for";
    case Flaw::Count:
      return "wrong number of triggers";
    case Flaw::Tick:
      return "triggers that do not follow each other";
  }
  return "unknown";
}

ParsedReport parse_input(std::span<const std::uint8_t> bytes, std::uint8_t report_id) noexcept {
  ParsedReport parsed;
  if (bytes.size() != GLINT_SYNC_REPORT_BYTES) {
    parsed.flaw = Flaw::Length;
    return parsed;
  }
  glint_sync_input wire;
  std::memcpy(&wire, bytes.data(), sizeof wire);
  if (wire.report_id != report_id) {
    parsed.flaw = Flaw::ReportId;
  } else if (wire.protocol != GLINT_SYNC_PROTOCOL_MAJOR) {
    parsed.flaw = Flaw::Protocol;
  } else if (wire.kind == GLINT_SYNC_KIND_GONE && report_id != GLINT_SYNC_FETCH) {
    parsed.flaw = Flaw::Kind;
  } else if (wire.kind != GLINT_SYNC_KIND_TRIGGERS && wire.count != 0) {
    parsed.flaw = Flaw::Count;
  }
  if (parsed.flaw != Flaw::None) return parsed;

  InputReport& report = parsed.report;
  report.epoch = wire.epoch;
  report.report_no = wire.report_no;
  report.run = wire.run;
  report.supply_mv = wire.supply_mv;
  report.unsent = wire.unsent;
  report.queued = wire.queued;
  report.flags = wire.flags;
  if (wire.kind == GLINT_SYNC_KIND_TRIGGERS) {
    Triggers triggers;
    parsed.flaw = read_triggers(wire, triggers);
    report.content = ReportContent(triggers);
  } else if (wire.kind == GLINT_SYNC_KIND_GONE) {
    report.content = ReportContent(NotHeld{wire.report_no});
  } else {
    report.content = ReportContent(Event{event_kind(wire.kind), wire.tick, wire.sequence, wire.detail});
  }
  return parsed;
}

}  // namespace glint::sync
