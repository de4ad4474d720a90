// SPDX-License-Identifier: MIT
#include "usb-sync/board_state.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "usb-sync/board_plan.hpp"
#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

/// The report as its struct, if it is one of this protocol.
template <class Wire>
std::optional<Wire> as(std::span<const std::uint8_t> bytes, std::uint8_t report_id) noexcept {
  static_assert(sizeof(Wire) == GLINT_SYNC_REPORT_BYTES);
  if (bytes.size() != sizeof(Wire) || bytes[0] != report_id || bytes[1] != GLINT_SYNC_PROTOCOL_MAJOR) {
    return std::nullopt;
  }
  Wire wire;
  std::memcpy(&wire, bytes.data(), sizeof wire);
  return wire;
}

std::uint16_t thousandths(double value, const char* what) {
  const double rounded = std::round(1e3 * value);
  if (!(rounded >= 0.0 && rounded <= 65535.0)) {  // not a number is neither
    throw Error(std::string(what) + " is " + std::to_string(value) + "; it must be 0 to 65.5");
  }
  return static_cast<std::uint16_t>(rounded);
}

bool near(Seconds one, Seconds other, Seconds tolerance) noexcept {
  constexpr Seconds kRounding{1e-12};
  return std::chrono::abs(one - other) <= tolerance + kRounding;
}

}  // namespace

std::string Info::firmware_text() const {
  return std::to_string(firmware_version >> 16) + "." + std::to_string(firmware_version >> 8 & 0xffu) + "." +
         std::to_string(firmware_version & 0xffu);
}

bool SelfTestResult::passed() const noexcept {
  return state == State::Done && sent > 0 && seen == sent && near(least_width, width, resolution) &&
         near(most_width, width, resolution) && near(least_period, period, 2.0 * resolution) &&
         near(most_period, period, 2.0 * resolution);
}

std::optional<Info> parse_info(std::span<const std::uint8_t> bytes) {
  const auto wire = as<glint_sync_info>(bytes, GLINT_SYNC_INFO);
  if (!wire || wire->tick_hz == 0) return std::nullopt;
  Info info;
  info.protocol_major = wire->protocol;
  info.protocol_minor = wire->protocol_minor;
  info.outputs = wire->outputs;
  info.triggers = wire->triggers;
  info.strobes_active_low = wire->strobes_active_low != 0;
  info.firmware_version = wire->firmware_version;
  info.tick_hz = wire->tick_hz;
  info.held_reports = wire->held_reports;
  info.epoch = wire->epoch;
  for (const std::uint8_t byte : wire->serial) {
    info.serial += "0123456789ABCDEF"[byte >> 4];
    info.serial += "0123456789ABCDEF"[byte & 15];
  }
  // Goes to terminals and JSON: nothing but plain characters.
  const auto* end = std::find(std::begin(wire->build), std::end(wire->build), '\0');
  std::copy_if(std::begin(wire->build), end, std::back_inserter(info.build),
               [](char c) { return c >= ' ' && c <= '~'; });
  return info;
}

std::optional<Status> parse_status(std::span<const std::uint8_t> bytes) noexcept {
  const auto wire = as<glint_sync_status>(bytes, GLINT_SYNC_STATUS);
  if (!wire || wire->state > GLINT_SYNC_TESTING) return std::nullopt;
  Status status;
  status.state = static_cast<RunState>(wire->state);
  status.supply_locked = (wire->flags & GLINT_SYNC_FLAG_LOCKED) != 0;
  status.after_watchdog = (wire->flags & GLINT_SYNC_FLAG_WATCHDOG) != 0;
  status.epoch = wire->epoch;
  status.next_report_no = wire->next_report_no;
  status.run = wire->run;
  status.supply_v = 1e-3 * wire->supply_mv;
  status.now_tick = wire->now_tick;
  status.sequence = wire->sequence;
  status.applied_sequence = wire->applied_sequence;
  status.unsent = wire->unsent;
  status.ignored_edges = wire->ignored_edges;
  status.held_strobes = wire->held_strobes;
  status.lockouts = wire->lockouts;
  status.fault = wire->fault;
  status.stop_reason = wire->stop_reason;
  status.reset_reason = wire->reset_reason;
  status.refusal = wire->refusal;
  if (wire->refusal_output < GLINT_SYNC_OUTPUTS) status.refusal_output = wire->refusal_output;
  status.refusal_limit = wire->refusal_limit;
  return status;
}

std::optional<Limits> parse_limits(std::span<const std::uint8_t> bytes, std::uint32_t tick_hz) noexcept {
  const auto wire = as<glint_sync_limits>(bytes, GLINT_SYNC_LIMITS);
  if (!wire) return std::nullopt;
  const auto seconds = [tick_hz](std::uint32_t ticks) { return seconds_of(ticks, tick_hz); };
  return Limits{.lockout_v = 1e-3 * wire->lockout_mv,
                .rearm_v = 1e-3 * wire->rearm_mv,
                .strobe_max_duty = 1e-3 * wire->strobe_max_duty_permille,
                .strobe_max_width = seconds(wire->strobe_max_width_ticks),
                .min_period = seconds(wire->min_period_ticks),
                .max_period = seconds(wire->max_period_ticks),
                .min_width = seconds(wire->min_width_ticks),
                .min_gap = seconds(wire->min_gap_ticks)};
}

glint_sync_limits to_report(const Limits& limits, std::uint32_t tick_hz) {
  glint_sync_limits wire{};
  wire.report_id = GLINT_SYNC_LIMITS;
  wire.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  wire.lockout_mv = thousandths(limits.lockout_v, "the lockout voltage");
  wire.rearm_mv = thousandths(limits.rearm_v, "the re-arm voltage");
  wire.strobe_max_duty_permille = thousandths(limits.strobe_max_duty, "the greatest duty");
  wire.strobe_max_width_ticks = ticks_of(limits.strobe_max_width, tick_hz, "the greatest width of strobes");
  return wire;
}

std::optional<SelfTestResult> parse_selftest(std::span<const std::uint8_t> bytes,
                                             std::uint32_t tick_hz) noexcept {
  const auto wire = as<glint_sync_selftest>(bytes, GLINT_SYNC_SELFTEST);
  if (!wire || wire->state > GLINT_SYNC_SELFTEST_DONE || wire->output >= GLINT_SYNC_OUTPUTS) {
    return std::nullopt;
  }
  const auto seconds = [tick_hz](std::uint32_t ticks) { return seconds_of(ticks, tick_hz); };
  return SelfTestResult{.state = static_cast<SelfTestResult::State>(wire->state),
                        .output = wire->output,
                        .sent = wire->sent,
                        .seen = wire->seen,
                        .resolution = seconds(wire->resolution_ticks),
                        .width = seconds(wire->width_ticks),
                        .least_width = seconds(wire->least_width_ticks),
                        .most_width = seconds(wire->most_width_ticks),
                        .period = seconds(wire->period_ticks),
                        .least_period = seconds(wire->least_period_ticks),
                        .most_period = seconds(wire->most_period_ticks)};
}

}  // namespace glint::sync
