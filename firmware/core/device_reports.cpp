// SPDX-License-Identifier: MIT
// What the host gets and sets.
#include "firmware/core/bytes.hpp"
#include "firmware/core/sync_device.hpp"

namespace glint::board {

bool SyncDevice::set_report(const uint8_t* bytes, uint32_t size, uint64_t now, Request& request) {
  last_word_ = now;
  request = Request::None;
  const Refusal refusal = set(bytes, size, now, request);
  // A program that only fetches must not hide from another one why it was refused.
  if (refusal || bytes[0] != GLINT_SYNC_FETCH) refusal_ = refusal;
  return !refusal;
}

Refusal SyncDevice::set(const uint8_t* bytes, uint32_t size, uint64_t now, Request& request) {
  if (size != GLINT_SYNC_REPORT_BYTES || bytes[1] != GLINT_SYNC_PROTOCOL_MAJOR)
    return {GLINT_SYNC_REFUSED_FORMAT, 0xff, GLINT_SYNC_PROTOCOL_MAJOR};
  const uint8_t id = bytes[0];
  if (id >= GLINT_SYNC_OUTPUT && id < GLINT_SYNC_OUTPUT + GLINT_SYNC_OUTPUTS) {
    copy_bytes(&staged_.outputs[id - GLINT_SYNC_OUTPUT], bytes, size);
    return {};
  }
  switch (id) {
    case GLINT_SYNC_RUN:
      copy_bytes(&staged_.run, bytes, size);
      return {};
    case GLINT_SYNC_LIMITS: {
      glint_sync_limits limits;
      copy_bytes(&limits, bytes, size);
      return set_limits(limits);
    }
    case GLINT_SYNC_COMMAND: {
      glint_sync_command wanted;
      copy_bytes(&wanted, bytes, size);
      return command(wanted, now, request);
    }
    case GLINT_SYNC_FETCH: {
      glint_sync_fetch fetch;
      copy_bytes(&fetch, bytes, size);
      fetch_no_ = fetch.report_no;
      return {};
    }
    default:
      return {GLINT_SYNC_REFUSED_REPORT, 0xff, 0};
  }
}

Refusal SyncDevice::set_limits(const glint_sync_limits& wanted) {
  if (running()) return {GLINT_SYNC_REFUSED_STATE, 0xff, 0};
  if (wanted.lockout_mv > kCapLockout_mv) return {GLINT_SYNC_REFUSED_LOCKOUT, 0xff, kCapLockout_mv};
  if (wanted.rearm_mv > kCapRearm_mv) return {GLINT_SYNC_REFUSED_REARM, 0xff, kCapRearm_mv};
  if (wanted.rearm_mv + kLeastHysteresis_mv > wanted.lockout_mv)
    return {GLINT_SYNC_REFUSED_REARM, 0xff, uint32_t{wanted.lockout_mv} - kLeastHysteresis_mv};
  if (wanted.strobe_max_duty_permille > kCapStrobeDuty_permille)
    return {GLINT_SYNC_REFUSED_STROBE_DUTY, 0xff, kCapStrobeDuty_permille};
  if (wanted.strobe_max_duty_permille == 0) return {GLINT_SYNC_REFUSED_FORMAT, 0xff, 1};
  if (wanted.strobe_max_width_ticks > kCapStrobeWidth)
    return {GLINT_SYNC_REFUSED_STROBE_WIDTH, 0xff, kCapStrobeWidth};
  planner_.set_limits(
      {wanted.lockout_mv, wanted.rearm_mv, wanted.strobe_max_duty_permille, wanted.strobe_max_width_ticks});
  return {};
}

Refusal SyncDevice::command(const glint_sync_command& command, uint64_t now, Request& request) {
  switch (command.command) {
    case GLINT_SYNC_COMMAND_STOP:
      if (running()) stop_planning(GLINT_SYNC_STOP_COMMAND, now);
      return {};
    case GLINT_SYNC_COMMAND_START:
      return start(staged_, now);
    case GLINT_SYNC_COMMAND_APPLY:
      return apply();
    case GLINT_SYNC_COMMAND_CLEAR:
      fault_ = GLINT_SYNC_FAULT_NONE;
      return {};
    case GLINT_SYNC_COMMAND_KEEP_ALIVE:
      return {};
    case GLINT_SYNC_COMMAND_SELFTEST:
      return start_self_test(command.argument, now);
    case GLINT_SYNC_COMMAND_RESET:
      if (command.argument != GLINT_SYNC_MAGIC_RESET) return {GLINT_SYNC_REFUSED_MAGIC, 0xff, 0};
      request = Request::Reset;
      return {};
    case GLINT_SYNC_COMMAND_BOOTLOADER:
      if (command.argument != GLINT_SYNC_MAGIC_BOOTLOADER) return {GLINT_SYNC_REFUSED_MAGIC, 0xff, 0};
      request = Request::Bootloader;
      return {};
    default:
      return {GLINT_SYNC_REFUSED_FORMAT, 0xff, 0};
  }
}

/// Takes a plan that differs in more than a run can change for a mistake.
Refusal SyncDevice::apply() {
  if (!running() || !planning_ || state_ == GLINT_SYNC_TESTING) return {GLINT_SYNC_REFUSED_STATE, 0xff, 0};
  if (staged_.run.flags != active_.run.flags) return {GLINT_SYNC_REFUSED_STATE, 0xff, active_.run.flags};
  for (uint8_t i = 0; i < GLINT_SYNC_TRIGGERS; ++i)
    if (staged_.active_low(i) != active_.active_low(i))
      return {GLINT_SYNC_REFUSED_POLARITY, i, active_.active_low(i)};
  if (const Refusal refusal = check(staged_, planner_.limits(), identity_.strobes_active_low)) return refusal;
  applied_ = staged_;
  apply_pending_ = true;
  return {};
}

bool SyncDevice::get_report(uint8_t report_id, uint8_t* bytes, uint64_t asked, uint64_t now) {
  last_word_ = now;
  const auto answer = [bytes, report_id](auto report) {
    static_assert(sizeof report == GLINT_SYNC_REPORT_BYTES);
    report.report_id = report_id;
    report.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
    copy_bytes(bytes, &report, sizeof report);
    return true;
  };
  if (report_id >= GLINT_SYNC_OUTPUT && report_id < GLINT_SYNC_OUTPUT + GLINT_SYNC_OUTPUTS)
    return answer(staged_.outputs[report_id - GLINT_SYNC_OUTPUT]);
  switch (report_id) {
    case GLINT_SYNC_STATUS:
      return answer(status(now));
    case GLINT_SYNC_RUN:
      return answer(staged_.run);
    case GLINT_SYNC_LIMITS:
      return answer(limits());
    case GLINT_SYNC_INFO:
      return answer(info());
    case GLINT_SYNC_SELFTEST:
      return answer(self_test_);
    case GLINT_SYNC_TIME: {
      glint_sync_time time{};
      time.epoch = identity_.epoch;
      time.tick = asked;
      time.queries = ++time_queries_;
      return answer(time);
    }
    case GLINT_SYNC_FETCH: {
      const glint_sync_input* held = log_.find(fetch_no_);
      if (held != nullptr) return answer(*held);
      glint_sync_input gone{};
      gone.kind = GLINT_SYNC_KIND_GONE;
      gone.epoch = identity_.epoch;
      gone.report_no = log_.oldest_no();
      return answer(gone);
    }
    default:
      return false;
  }
}

glint_sync_input& SyncDevice::event(uint8_t kind, uint64_t tick, uint32_t detail) {
  glint_sync_input& report = log_.append(kind, run_);
  report.flags = flags();
  report.supply_mv = supply_.average_mv();
  report.tick = tick;
  report.detail = detail;
  return report;
}

uint8_t SyncDevice::flags() const {
  uint8_t bits = 0;
  if (locked_) bits |= GLINT_SYNC_FLAG_LOCKED;
  if (fault_ != GLINT_SYNC_FAULT_NONE) bits |= GLINT_SYNC_FLAG_FAULT;
  if (identity_.reset_reason == GLINT_SYNC_RESET_WATCHDOG) bits |= GLINT_SYNC_FLAG_WATCHDOG;
  return bits;
}

glint_sync_status SyncDevice::status(uint64_t now) const {
  glint_sync_status status{};
  status.state = state_;
  status.flags = flags();
  status.epoch = identity_.epoch;
  status.next_report_no = log_.next_no();
  status.run = run_;
  status.supply_mv = supply_.average_mv();
  status.now_tick = now;
  status.sequence = record_.begun;
  status.applied_sequence = record_.applied_sequence;
  status.unsent = log_.unsent();
  status.ignored_edges = record_.ignored_edges;
  status.fault = fault_;
  status.refusal = refusal_.reason;
  status.refusal_output = refusal_.output;
  status.reset_reason = identity_.reset_reason;
  status.refusal_limit = refusal_.limit;
  status.held_strobes = planner_.held_strobes();
  status.lockouts = lockouts_;
  status.stop_reason = record_.stop_reason;
  return status;
}

glint_sync_limits SyncDevice::limits() const {
  glint_sync_limits limits{};
  limits.lockout_mv = planner_.limits().lockout_mv;
  limits.rearm_mv = planner_.limits().rearm_mv;
  limits.strobe_max_duty_permille = planner_.limits().max_duty_permille;
  limits.strobe_max_width_ticks = planner_.limits().max_width;
  limits.min_period_ticks = kMinPeriod;
  limits.max_period_ticks = kMaxPeriod;
  limits.min_width_ticks = kMinWidth;
  limits.min_gap_ticks = kMinGap;
  return limits;
}

glint_sync_info SyncDevice::info() const {
  glint_sync_info info{};
  info.protocol_minor = GLINT_SYNC_PROTOCOL_MINOR;
  info.outputs = GLINT_SYNC_OUTPUTS;
  info.triggers = GLINT_SYNC_TRIGGERS;
  info.strobes_active_low = identity_.strobes_active_low ? 1 : 0;
  info.firmware_version = identity_.firmware_version;
  info.tick_hz = kTickHz;
  info.held_reports = ReportLog::kHeld;
  info.epoch = identity_.epoch;
  copy_bytes(info.serial, identity_.serial, sizeof info.serial);
  for (unsigned i = 0; i + 1 < sizeof info.build && identity_.build[i] != 0; ++i)
    info.build[i] = identity_.build[i];
  return info;
}

}  // namespace glint::board
