// SPDX-License-Identifier: MIT
#include "firmware/core/plan.hpp"

#include "firmware/protocol/pulse_code.h"

namespace glint::board {
namespace {

Refusal check_run(const glint_sync_run& run) {
  if (run.period_ticks < kMinPeriod) return {GLINT_SYNC_REFUSED_PERIOD_SHORT, 0xff, kMinPeriod};
  if (run.period_ticks > kMaxPeriod) return {GLINT_SYNC_REFUSED_PERIOD_LONG, 0xff, kMaxPeriod};
  if (run.code_group != 0 && run.code_group < GLINT_PULSE_CODE_LEAST_GROUP)
    return {GLINT_SYNC_REFUSED_CODE, 0xff, GLINT_PULSE_CODE_LEAST_GROUP};
  if (run.code_group > GLINT_PULSE_CODE_MOST_GROUP)
    return {GLINT_SYNC_REFUSED_CODE, 0xff, GLINT_PULSE_CODE_MOST_GROUP};
  if (run.dark_width_ticks != 0 && run.dark_width_ticks < kMinWidth)
    return {GLINT_SYNC_REFUSED_WIDTH_SHORT, 0xff, kMinWidth};
  return {};
}

Refusal check_output(const Plan& plan, uint8_t index) {
  const glint_sync_output& output = plan.outputs[index];
  const uint32_t period = plan.run.period_ticks;
  if (output.every_n == 0) return {GLINT_SYNC_REFUSED_FORMAT, index, 1};
  if (output.phase >= output.every_n) return {GLINT_SYNC_REFUSED_PHASE, index, output.every_n};
  if (output.delay_ticks >= period) return {GLINT_SYNC_REFUSED_DELAY, index, period};
  if (output.width_ticks < kMinWidth) return {GLINT_SYNC_REFUSED_WIDTH_SHORT, index, kMinWidth};
  uint32_t longest = period - kMinGap;
  const uint32_t latest_end = plan.external() ? period - kMinGap : period + period / 2;
  const uint32_t room = latest_end > output.delay_ticks ? latest_end - output.delay_ticks : 0;
  if (room < longest) longest = room;
  if (output.width_ticks > longest) return {GLINT_SYNC_REFUSED_WIDTH_LONG, index, longest};
  return {};
}

Refusal check_strobe(const Plan& plan, uint8_t index, const StrobeLimits& limits, bool active_low) {
  const glint_sync_output& output = plan.outputs[index];
  if (plan.active_low(index) != active_low) return {GLINT_SYNC_REFUSED_POLARITY, index, active_low};
  if (output.width_ticks > limits.max_width)
    return {GLINT_SYNC_REFUSED_STROBE_WIDTH, index, limits.max_width};
  if (limits.least_interval(output.width_ticks) > uint64_t{plan.run.period_ticks} * output.every_n)
    return {GLINT_SYNC_REFUSED_STROBE_DUTY, index, limits.max_duty_permille};
  return {};
}

}  // namespace

Plan default_plan() {
  Plan plan;
  plan.run.report_id = GLINT_SYNC_RUN;
  plan.run.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  plan.run.period_ticks = kTickHz / 90;
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    plan.outputs[i].report_id = static_cast<uint8_t>(GLINT_SYNC_OUTPUT + i);
    plan.outputs[i].protocol = GLINT_SYNC_PROTOCOL_MAJOR;
    plan.outputs[i].every_n = 1;
    plan.outputs[i].width_ticks = ticks_of_us(100);
  }
  return plan;
}

Refusal check(const Plan& plan, const StrobeLimits& limits, bool strobes_active_low) {
  if (const Refusal refusal = check_run(plan.run)) return refusal;
  bool any = false;
  for (uint8_t i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    if (!plan.enabled(i)) continue;
    any = true;
    if (const Refusal refusal = check_output(plan, i)) return refusal;
    if (!is_strobe(i)) continue;
    if (const Refusal refusal = check_strobe(plan, i, limits, strobes_active_low)) return refusal;
  }
  if (!any) return {GLINT_SYNC_REFUSED_NO_OUTPUT, 0xff, 0};
  return {};
}

}  // namespace glint::board
