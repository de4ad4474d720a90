// SPDX-License-Identifier: MIT
// Runs: from START to STOPPED, with all that can come between.
#include "firmware/core/sync_device.hpp"

namespace glint::board {
namespace {

/// A frame is planned that long before the one before it begins. Early enough for the longest delay of a
/// timer and the planning itself; late enough that a dead processor leaves few pulses.
constexpr uint32_t kPlanLead = ticks_of_us(64);
/// Planning that begins later than that before the frame might not be done in time.
constexpr uint32_t kLeastLead = kPlanLead - SyncDevice::kMostTimerDelay;
/// From START to the first frame at least: planning takes 30 us or so.
constexpr uint32_t kStartLead = ticks_of_us(500);
/// After the last pulse, before the outputs are switched off.
constexpr uint32_t kEndMargin = ticks_of_us(10);
/// Between two looks at a sync in that is active when it should be armed.
constexpr uint32_t kArmRetry = ticks_of_us(50);
constexpr uint64_t kSamplesOverdue = ticks_of_us(10'000);

constexpr uint8_t kStrobeMask = 0xff & ~((1 << GLINT_SYNC_TRIGGERS) - 1);

}  // namespace

SyncDevice::SyncDevice(PulseHardware& hardware, const Identity& identity, uint64_t now)
    : hardware_(hardware), identity_(identity), log_(identity.epoch), planner_(now), staged_(default_plan()) {
  for (unsigned i = GLINT_SYNC_TRIGGERS; i < GLINT_SYNC_OUTPUTS; ++i)
    if (identity.strobes_active_low) staged_.outputs[i].flags |= GLINT_SYNC_OUTPUT_ACTIVE_LOW;
  active_ = staged_;
  event(GLINT_SYNC_KIND_BOOTED, now, identity.reset_reason);
}

uint64_t SyncDevice::next_due() const {
  if (!running()) return kNever;
  uint64_t due = ends_at_;
  const auto sooner = [&due](uint64_t tick) {
    if (tick < due) due = tick;
  };
  if (record_.begun < planned_ && !active_.external()) sooner(waiting_[record_.begun % 4].tick);
  if (planning_) sooner(active_.external() ? arm_at_ : frame_.tick - kPlanLead);
  if (active_.run.keepalive_ms != 0)
    sooner(last_word_ + uint64_t{active_.run.keepalive_ms} * (kTickHz / 1000));
  return due;
}

void SyncDevice::on_timer(uint64_t now) {
  if (!running()) return;
  if (!active_.external()) {
    if (planning_ && now >= frame_.tick - kPlanLead) plan_next(now);
    while (running() && record_.begun < planned_ && now >= waiting_[record_.begun % 4].tick)
      log_trigger(waiting_[record_.begun % 4]);
  } else if (planning_ && now >= arm_at_) {
    arm(now);
  }
  if (state_ == GLINT_SYNC_TESTING) collect_self_test();
  const uint64_t silence = uint64_t{active_.run.keepalive_ms} * (kTickHz / 1000);
  if (silence != 0 && now >= last_word_ + silence) {
    last_word_ = now;  // so that this is not due again while the last pulses end
    stop_planning(GLINT_SYNC_STOP_HOST_GONE, now);
  }
  if (running() && now >= ends_at_) finish();
}

Refusal SyncDevice::start(const Plan& plan, uint64_t now) {
  if (running()) return {GLINT_SYNC_REFUSED_STATE, 0xff, 0};
  if (fault_ == GLINT_SYNC_FAULT_NONE && now - last_sample_ > kSamplesOverdue)
    fault_ = GLINT_SYNC_FAULT_SUPPLY;
  if (fault_ != GLINT_SYNC_FAULT_NONE) return {GLINT_SYNC_REFUSED_FAULT, 0xff, fault_};
  if (const Refusal refusal = check(plan, planner_.limits(), identity_.strobes_active_low)) return refusal;
  ++run_;
  begin(plan, now, -1);
  event(GLINT_SYNC_KIND_STARTED, active_.external() ? now : frame_.tick, 0);
  return {};
}

void SyncDevice::begin(const Plan& plan, uint64_t now, int measured) {
  active_ = plan;
  apply_pending_ = false;
  record_ = {};
  planned_ = 0;
  ends_at_ = kNever;
  planning_ = true;
  armed_ = false;
  last_word_ = now;
  PulseHardware::Setup setup{0, (plan.run.flags & GLINT_SYNC_RUN_SYNC_OUT) != 0, plan.external(),
                             (plan.run.flags & GLINT_SYNC_RUN_FALLING_EDGE) != 0, measured};
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    const bool low = is_strobe(i) ? identity_.strobes_active_low : plan.active_low(i);
    if (low) setup.active_low |= static_cast<uint8_t>(1u << i);
  }
  hardware_.prepare(setup);
  planner_.begin_run(now);
  if (active_.external()) {
    state_ = GLINT_SYNC_WAITING;
    arm_at_ = now;
    return;
  }
  state_ = measured < 0 ? GLINT_SYNC_RUNNING : GLINT_SYNC_TESTING;
  frame_ = planner_.plan_frame(active_, planner_.earliest_frame(active_, now + kStartLead, 0), 0, locked_);
  feed(frame_);
  planner_.shift(frame_, hardware_.open_gate() - now);
  waiting_[0] = {frame_.tick, 0, frame_.outputs, frame_.flags};
  planned_ = 1;
  if (active_.run.pulses == 1) stop_planning(GLINT_SYNC_STOP_BURST_END, now);
}

void SyncDevice::plan_next(uint64_t now) {
  if (now + kLeastLead > frame_.tick || hardware_.ran_dry()) return fail(GLINT_SYNC_FAULT_UNDERRUN);
  if (now - last_sample_ > kSamplesOverdue) return fail(GLINT_SYNC_FAULT_SUPPLY);
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i)
    if (hardware_.waiting_words(i) > 2) return fail(GLINT_SYNC_FAULT_STALLED);
  const uint64_t nominal = frame_.tick + active_.run.period_ticks;
  take_applied(now);
  frame_ =
      planner_.plan_frame(active_, planner_.earliest_frame(active_, nominal, planned_), planned_, locked_);
  feed(frame_);
  waiting_[planned_ % 4] = {frame_.tick, planned_, frame_.outputs, frame_.flags};
  ++planned_;
  if (active_.run.pulses != 0 && planned_ >= active_.run.pulses)
    stop_planning(GLINT_SYNC_STOP_BURST_END, now);
}

void SyncDevice::take_applied(uint64_t now) {
  if (!apply_pending_) return;
  active_ = applied_;
  apply_pending_ = false;
  record_.applied_sequence = planned_;
  event(GLINT_SYNC_KIND_APPLIED, now, 0).sequence = planned_;
}

void SyncDevice::arm(uint64_t now) {
  if (now - last_sample_ > kSamplesOverdue) return fail(GLINT_SYNC_FAULT_SUPPLY);
  if (planned_ == record_.begun) {
    hardware_.disarm();  // what is fed must not begin before all of it is
    take_applied(now);
    // The gate must not open before: a frame begins with its edge, wherever it was planned.
    const uint64_t earliest = planner_.earliest_frame(active_, now, planned_);
    if (earliest > now) {
      arm_at_ = earliest;
      return;
    }
    frame_ = planner_.plan_frame(active_, now, planned_, locked_);
    feed(frame_);
    ++planned_;
  }
  bool missed = false;
  armed_ = hardware_.arm(missed);
  if (missed) ++record_.ignored_edges;
  arm_at_ = armed_ ? kNever : now + kArmRetry;
}

void SyncDevice::on_edge(uint64_t edge) {
  if (!armed_) return;
  armed_ = false;
  if (edge > frame_.tick) planner_.shift(frame_, edge - frame_.tick);
  log_trigger(
      {edge, planned_ - 1, frame_.outputs, static_cast<uint8_t>(frame_.flags | GLINT_SYNC_TRIGGER_EXTERNAL)});
  if (!planning_) {  // stopped meanwhile
    ends_at_ = planner_.last_end() + kEndMargin;
    return;
  }
  if (active_.run.pulses != 0 && record_.begun >= active_.run.pulses)
    return stop_planning(GLINT_SYNC_STOP_BURST_END, edge);
  arm_at_ = planner_.earliest_frame(active_, edge + active_.run.period_ticks, planned_);
}

void SyncDevice::feed(const Frame& frame) {
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    const Segment& segment = frame.segments[i];
    const uint64_t from_gate = segment.begin_tick - frame.tick;
    hardware_.feed(i, active_.external() ? static_cast<uint32_t>(from_gate) : segment.low, segment.width);
  }
}

void SyncDevice::log_trigger(Planned fired) {
  ++record_.begun;
  if (state_ == GLINT_SYNC_TESTING) return;
  if (locked_) {
    fired.outputs &= static_cast<uint8_t>(~kStrobeMask);
    fired.flags |= GLINT_SYNC_TRIGGER_LOCKED;
  }
  if (active_.run.pulses != 0 && record_.begun >= active_.run.pulses) fired.flags |= GLINT_SYNC_TRIGGER_LAST;
  const uint64_t step = fired.tick - last_logged_;
  glint_sync_input* report = step <= 0xffffffff ? log_.open_triggers(run_) : nullptr;
  if (report == nullptr) {
    report = &event(GLINT_SYNC_KIND_TRIGGERS, fired.tick, 0);
    report->sequence = fired.sequence;
  } else {
    report->step_ticks[report->count - 1] = static_cast<uint32_t>(step);
    report->flags = flags();
    report->supply_mv = supply_.average_mv();
  }
  report->outputs[report->count] = fired.outputs;
  report->trigger_flags[report->count] = fired.flags;
  ++report->count;
  last_logged_ = fired.tick;
}

/// What is planned still happens; a gate that nothing has gone through is closed.
void SyncDevice::stop_planning(uint8_t reason, uint64_t now) {
  if (!planning_) return;
  planning_ = false;
  record_.stop_reason = reason;
  armed_ = armed_ && hardware_.disarm();
  if (armed_) {
    ends_at_ = now + active_.run.period_ticks;  // an edge is on its way: on_edge() knows better
  } else if (active_.external() && planned_ != record_.begun) {
    ends_at_ = now;
  } else {
    ends_at_ = planner_.last_end() + kEndMargin;
  }
}

void SyncDevice::finish() {
  hardware_.halt();
  if (state_ == GLINT_SYNC_TESTING) {
    collect_self_test();
    self_test_.state = GLINT_SYNC_SELFTEST_DONE;
    record_ = record_before_test_;
  } else {
    event(GLINT_SYNC_KIND_STOPPED, ends_at_, record_.stop_reason | uint32_t{fault_} << 8).sequence =
        record_.begun;
  }
  state_ = GLINT_SYNC_IDLE;
  planning_ = armed_ = apply_pending_ = false;
}

void SyncDevice::fail(uint8_t fault) {
  fault_ = fault;
  record_.stop_reason = GLINT_SYNC_STOP_FAULT;
  ends_at_ = frame_.tick;
  finish();
}

void SyncDevice::on_supply(uint16_t mv, uint64_t now) {
  supply_.add(mv, planner_.limits());
  last_sample_ = now;
  if (!locked_ && supply_.too_high()) {
    locked_ = true;
    ++lockouts_;
    hardware_.hold_strobes(true);
    event(GLINT_SYNC_KIND_LOCKED, now, mv).sequence = record_.begun;
  } else if (locked_ && supply_.low_enough() && now > planner_.last_strobe_end()) {
    // Strobes planned before the lockout are over, so that none is cut short.
    locked_ = false;
    hardware_.hold_strobes(false);
    event(GLINT_SYNC_KIND_REARMED, now, mv).sequence = planned_;
  }
}

void SyncDevice::on_bus_lost(uint64_t now) {
  if (running() && active_.run.keepalive_ms != 0) {
    last_word_ = now;
    stop_planning(GLINT_SYNC_STOP_HOST_GONE, now);
  }
}

Refusal SyncDevice::start_self_test(uint32_t output, uint64_t now) {
  if (output >= GLINT_SYNC_OUTPUTS) return {GLINT_SYNC_REFUSED_NO_OUTPUT, 0xff, GLINT_SYNC_OUTPUTS - 1};
  if (running()) return {GLINT_SYNC_REFUSED_STATE, 0xff, 0};
  if (locked_ && is_strobe(output)) return {GLINT_SYNC_REFUSED_SUPPLY, 0xff, 0};
  constexpr uint32_t kPulses = 32, kPeriod = ticks_of_us(10'000), kWidth = ticks_of_us(137);
  Plan plan = default_plan();
  plan.run.period_ticks = kPeriod;
  plan.run.pulses = kPulses;
  plan.outputs[output].flags = GLINT_SYNC_OUTPUT_ENABLED;
  if (is_strobe(output) ? identity_.strobes_active_low : staged_.active_low(output))
    plan.outputs[output].flags |= GLINT_SYNC_OUTPUT_ACTIVE_LOW;
  plan.outputs[output].width_ticks = kWidth;
  if (const Refusal refusal = check(plan, planner_.limits(), identity_.strobes_active_low)) return refusal;
  self_test_ = {};
  self_test_.state = GLINT_SYNC_SELFTEST_RUNNING;
  self_test_.output = static_cast<uint8_t>(output);
  self_test_.sent = kPulses;
  self_test_.resolution_ticks = hardware_.measure_resolution();
  self_test_.width_ticks = kWidth;
  self_test_.period_ticks = kPeriod;
  self_test_width_ = 0;
  record_before_test_ = record_;
  begin(plan, now, static_cast<int>(output));
  return {};
}

void SyncDevice::collect_self_test() {
  const auto widen = [](uint32_t value, uint32_t& least, uint32_t& most) {
    if (least == 0 || value < least) least = value;
    if (value > most) most = value;
  };
  uint32_t low = 0, width = 0;
  while (hardware_.take_measured(low, width)) {
    ++self_test_.seen;
    widen(width, self_test_.least_width_ticks, self_test_.most_width_ticks);
    if (self_test_width_ != 0)
      widen(self_test_width_ + low, self_test_.least_period_ticks, self_test_.most_period_ticks);
    self_test_width_ = width;
  }
}

}  // namespace glint::board
