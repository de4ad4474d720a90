// SPDX-License-Identifier: MIT
// Values to JSON.
#include "host/apps/sync_json.hpp"

#include <cmath>

#include "host/apps/sync_text.hpp"
#include "usb-sync/board_text.hpp"

namespace glint::apps {
namespace {

using Json = nlohmann::ordered_json;

/// To a picosecond: no digits that are rounding alone.
double us(sync::Seconds time) { return std::round(time.count() * 1e12) * 1e-6; }

const char* start_key(sync::FrameStart start) {
  switch (start) {
    case sync::FrameStart::Internal:
      return "internal";
    case sync::FrameStart::RisingEdge:
      return "rising_edge";
    case sync::FrameStart::FallingEdge:
      break;
  }
  return "falling_edge";
}

const char* outcome_key(RunOutcome::Kind kind) {
  switch (kind) {
    case RunOutcome::Kind::Started:
      return "started";
    case RunOutcome::Kind::Applied:
      return "applied";
    case RunOutcome::Kind::Restarted:
      break;
  }
  return "restarted";
}

}  // namespace

const char* state_key(sync::RunState state) {
  switch (state) {
    case sync::RunState::Idle:
      return "idle";
    case sync::RunState::Running:
      return "running";
    case sync::RunState::Waiting:
      return "waiting";
    case sync::RunState::Testing:
      break;
  }
  return "testing";
}

Json info_json(const sync::Info& info) {
  return {{"serial", info.serial},
          {"firmware", info.firmware_text()},
          {"build", info.build},
          {"protocol", std::to_string(info.protocol_major) + "." + std::to_string(info.protocol_minor)},
          {"outputs", info.outputs},
          {"triggers", info.triggers},
          {"strobes_active_low", info.strobes_active_low},
          {"tick_hz", info.tick_hz},
          {"held_reports", info.held_reports},
          {"epoch", info.epoch}};
}

Json status_json(const sync::Status& status) {
  return {{"state", state_key(status.state)},
          {"run", status.run},
          {"frames", status.sequence},
          {"applied_frame", status.applied_sequence},
          {"supply_v", status.supply_v},
          {"supply_locked", status.supply_locked},
          {"lockouts", status.lockouts},
          {"fault", status.fault},
          {"fault_text", sync::fault_text(status.fault)},
          {"stop_reason", status.stop_reason},
          {"stop_text", sync::stop_text(status.stop_reason)},
          {"reset_reason", status.reset_reason},
          {"reset_text", sync::reset_text(status.reset_reason)},
          {"after_watchdog", status.after_watchdog},
          {"next_report_no", status.next_report_no},
          {"unsent_reports", status.unsent},
          {"ignored_edges", status.ignored_edges},
          {"held_strobes", status.held_strobes},
          {"now_tick", status.now_tick},
          {"epoch", status.epoch}};
}

Json limits_json(const sync::Limits& limits) {
  return {{"lockout_v", limits.lockout_v},
          {"rearm_v", limits.rearm_v},
          {"strobe_max_duty", limits.strobe_max_duty},
          {"strobe_max_width_us", us(limits.strobe_max_width)},
          {"min_period_us", us(limits.min_period)},
          {"max_period_us", us(limits.max_period)},
          {"min_width_us", us(limits.min_width)},
          {"min_gap_us", us(limits.min_gap)}};
}

Json plan_json(const sync::BoardPlan& plan, std::uint32_t tick_hz) {
  Json outputs = Json::array();
  for (std::size_t i = 0; i < sync::kOutputs; ++i) {
    const sync::OutputPlan& output = plan.outputs[i];
    outputs.push_back({{"output", i},
                       {"pin", output_pin(i)},
                       {"kind", sync::is_strobe(i) ? "strobe" : "trigger"},
                       {"enabled", output.enabled},
                       {"active_low", output.active_low},
                       {"delay_us", us(output.delay)},
                       {"width_us", us(output.width)},
                       {"every_n", output.every_n},
                       {"phase", output.phase}});
  }
  return {{"begin", start_key(plan.start)}, {"rate_hz", 1.0 / plan.period.count()},
          {"period_us", us(plan.period)},   {"period_ticks", std::llround(plan.period.count() * tick_hz)},
          {"pulses", plan.pulses},          {"keepalive_ms", plan.keepalive.count()},
          {"sync_out", plan.sync_out},      {"code_seed", plan.code.seed},
          {"code_group", plan.code.group},  {"code_dark_width_us", us(plan.code.dark_width)},
          {"outputs", std::move(outputs)}};
}

Json run_json(const RunOutcome& outcome, std::uint32_t tick_hz) {
  Json json{
      {"outcome", outcome_key(outcome.kind)}, {"run", outcome.run}, {"supply_locked", outcome.supply_locked}};
  if (outcome.kind == RunOutcome::Kind::Restarted) json["previous_run"] = outcome.previous_run;
  if (outcome.first_frame) json["first_frame_after_us"] = us(*outcome.first_frame);
  if (outcome.applied_sequence) json["applied_frame"] = *outcome.applied_sequence;
  json["plan"] = plan_json(outcome.plan, tick_hz);
  return json;
}

Json selftest_json(const sync::SelfTestResult& result) {
  return {{"output", result.output},
          {"pin", output_pin(static_cast<std::size_t>(result.output))},
          {"passed", result.passed()},
          {"sent", result.sent},
          {"seen", result.seen},
          {"resolution_us", us(result.resolution)},
          {"width_us", us(result.width)},
          {"least_width_us", us(result.least_width)},
          {"most_width_us", us(result.most_width)},
          {"period_us", us(result.period)},
          {"least_period_us", us(result.least_period)},
          {"most_period_us", us(result.most_period)}};
}

}  // namespace glint::apps
