// SPDX-License-Identifier: MIT
#include "usb-sync/board_plan.hpp"

#include <cmath>
#include <limits>

#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

template <class Narrow>
Narrow fitting(long long value, const std::string& what) {
  if (value < 0 || value > std::numeric_limits<Narrow>::max()) {
    throw Error(what + " is " + std::to_string(value) + "; it must be 0 to " +
                std::to_string(std::numeric_limits<Narrow>::max()));
  }
  return static_cast<Narrow>(value);
}

constexpr std::uint8_t flag_if(bool set, int flag) noexcept {
  return set ? static_cast<std::uint8_t>(flag) : std::uint8_t{0};
}

}  // namespace

std::string output_name(std::size_t output) {
  return "output " + std::to_string(output) + (is_strobe(output) ? " (strobe)" : " (trigger)");
}

std::uint32_t ticks_of(Seconds time, std::uint32_t tick_hz, const std::string& what) {
  const double ticks = std::round(time.count() * static_cast<double>(tick_hz));
  constexpr double kMost = std::numeric_limits<std::uint32_t>::max();
  if (!(ticks >= 0.0 && ticks <= kMost)) {  // not a number is neither
    throw Error(what + " is " + time_text(time) + "; it must be 0 s to " +
                time_text(Seconds(kMost / static_cast<double>(tick_hz))));
  }
  return static_cast<std::uint32_t>(ticks);
}

PlanReports to_reports(const BoardPlan& plan, std::uint32_t tick_hz) {
  PlanReports reports;
  glint_sync_run& run = reports.run;
  run.report_id = GLINT_SYNC_RUN;
  run.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  run.flags =
      static_cast<std::uint8_t>(flag_if(plan.start != FrameStart::Internal, GLINT_SYNC_RUN_EXTERNAL) |
                                flag_if(plan.start == FrameStart::FallingEdge, GLINT_SYNC_RUN_FALLING_EDGE) |
                                flag_if(plan.sync_out, GLINT_SYNC_RUN_SYNC_OUT));
  run.period_ticks = ticks_of(plan.period, tick_hz, "the period");
  run.pulses = plan.pulses;
  run.code_seed = plan.code.seed;
  run.code_group = fitting<std::uint16_t>(plan.code.group, "the group of the dark code");
  run.keepalive_ms = fitting<std::uint16_t>(plan.keepalive.count(), "the keep-alive time in ms");
  run.dark_width_ticks = ticks_of(plan.code.dark_width, tick_hz, "the width in dark frames");

  for (std::size_t i = 0; i < kOutputs; ++i) {
    const OutputPlan& from = plan.outputs[i];
    glint_sync_output& to = reports.outputs[i];
    const std::string name = output_name(i);
    to.report_id = static_cast<std::uint8_t>(GLINT_SYNC_OUTPUT + i);
    to.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
    to.flags = static_cast<std::uint8_t>(flag_if(from.enabled, GLINT_SYNC_OUTPUT_ENABLED) |
                                         flag_if(from.active_low, GLINT_SYNC_OUTPUT_ACTIVE_LOW));
    to.every_n = fitting<std::uint8_t>(from.every_n, name + ": every_n");
    to.phase = fitting<std::uint8_t>(from.phase, name + ": phase");
    to.delay_ticks = ticks_of(from.delay, tick_hz, name + ": delay");
    to.width_ticks = ticks_of(from.width, tick_hz, name + ": width");
  }
  return reports;
}

BoardPlan from_reports(const PlanReports& reports, std::uint32_t tick_hz) noexcept {
  BoardPlan plan;
  const glint_sync_run& run = reports.run;
  if ((run.flags & GLINT_SYNC_RUN_EXTERNAL) != 0) {
    const bool falling = (run.flags & GLINT_SYNC_RUN_FALLING_EDGE) != 0;
    plan.start = falling ? FrameStart::FallingEdge : FrameStart::RisingEdge;
  }
  plan.sync_out = (run.flags & GLINT_SYNC_RUN_SYNC_OUT) != 0;
  plan.period = seconds_of(run.period_ticks, tick_hz);
  plan.pulses = run.pulses;
  plan.keepalive = std::chrono::milliseconds(run.keepalive_ms);
  plan.code = {run.code_seed, run.code_group, seconds_of(run.dark_width_ticks, tick_hz)};
  for (std::size_t i = 0; i < kOutputs; ++i) {
    const glint_sync_output& from = reports.outputs[i];
    plan.outputs[i] = {.enabled = (from.flags & GLINT_SYNC_OUTPUT_ENABLED) != 0,
                       .active_low = (from.flags & GLINT_SYNC_OUTPUT_ACTIVE_LOW) != 0,
                       .delay = seconds_of(from.delay_ticks, tick_hz),
                       .width = seconds_of(from.width_ticks, tick_hz),
                       .every_n = from.every_n,
                       .phase = from.phase};
  }
  return plan;
}

}  // namespace glint::sync
