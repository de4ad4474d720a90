// SPDX-License-Identifier: MIT
// Numbers to words.
#include "host/apps/sync_text.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

#include "usb-sync/board_text.hpp"

namespace glint::apps {
namespace {

using ull = unsigned long long;

constexpr unsigned kFirstPin = 2;

double us(sync::Seconds time) { return time.count() * 1e6; }

/// "  name       value".
std::string row(const char* name, const std::string& value) {
  return format_text("  %-10s ", name) + value + "\n";
}

/// What the grid of ticks has changed can be seen: times to a nanosecond.
bool differ(sync::Seconds one, sync::Seconds other) { return std::abs(one.count() - other.count()) > 0.5e-9; }

std::string rate_text(sync::Seconds period) { return format_text("%.6f Hz", 1.0 / period.count()); }

std::string frame_text(const sync::BoardPlan& plan, const sync::BoardPlan& asked, std::uint32_t tick_hz) {
  const auto ticks = static_cast<ull>(std::llround(plan.period.count() * tick_hz));
  std::string text =
      rate_text(plan.period) + format_text(": period %.3f us, %llu ticks of %s", us(plan.period), ticks,
                                           sync::time_text(sync::seconds_of(1, tick_hz)).c_str());
  if (differ(plan.period, asked.period))
    text += format_text(" (asked for %.9g Hz)", 1.0 / asked.period.count());
  return text;
}

std::string begin_text(const sync::BoardPlan& plan) {
  if (plan.start == sync::FrameStart::Internal) return "with the board's clock";
  return std::string(plan.start == sync::FrameStart::RisingEdge ? "with rising" : "with falling") +
         " edges at sync in (" + kSyncInPin + "), not more often than the rate";
}

std::string code_text(const sync::DarkCode& code) {
  std::string text = format_text("one frame in %d is dark, seed %u", code.group, code.seed);
  if (code.dark_width.count() > 0.0) text += format_text(", strobes last %.3f us there", us(code.dark_width));
  return text;
}

/// In which frames an output fires, and what else is unusual about it.
std::string output_notes(const sync::OutputPlan& output, const sync::OutputPlan& asked) {
  std::string text =
      output.every_n == 1 ? "all" : format_text("one in %d, from frame %d on", output.every_n, output.phase);
  if (output.active_low) text += ", active low";
  std::string other;
  if (differ(output.delay, asked.delay)) other += format_text(" delay %.6g us", us(asked.delay));
  if (differ(output.width, asked.width)) other += format_text(" width %.6g us", us(asked.width));
  return other.empty() ? text : text + " (asked for" + other + ")";
}

constexpr const char* kOutputHeader = "  output pin  kind        delay us     width us  frames\n";

std::string output_row(std::size_t i, const sync::OutputPlan& output, const sync::OutputPlan& asked) {
  return format_text("  %-6zu %-4s %-7s %12.3f %12.3f  ", i, output_pin(i).c_str(),
                     sync::is_strobe(i) ? "strobe" : "trigger", us(output.delay), us(output.width)) +
         output_notes(output, asked) + "\n";
}

std::string outputs_text(const sync::BoardPlan& plan, const sync::BoardPlan& asked) {
  std::string rows, off;
  for (std::size_t i = 0; i < sync::kOutputs; ++i) {
    if (plan.outputs[i].enabled) {
      rows += output_row(i, plan.outputs[i], asked.outputs[i]);
    } else {
      off += (off.empty() ? "" : ", ") + std::to_string(i);
    }
  }
  if (rows.empty()) return row("outputs", "all off");
  return kOutputHeader + rows + (off.empty() ? "" : row("off", off));
}

std::string state_line(const sync::Status& status) {
  std::string text = sync::state_text(status.state);
  if (status.run == 0) return text;
  const std::string frames = count_text(status.sequence, "frame");
  if (status.state == sync::RunState::Running || status.state == sync::RunState::Waiting)
    return text + format_text(", run %d, ", status.run) + frames;
  return text + format_text("; run %d ended after ", status.run) + frames + " because " +
         sync::stop_text(status.stop_reason);
}

std::string supply_line(const sync::Status& status, const sync::Limits& limits) {
  std::string text = format_text("%.2f V", status.supply_v);
  if (status.supply_locked) {
    text += format_text(": too high, STROBES ARE LOCKED OUT until it is below %.2f V", limits.rearm_v);
  } else {
    text += format_text("; strobes are locked out above %.2f V", limits.lockout_v);
  }
  if (status.lockouts > 0)
    text += "; " + count_text(static_cast<std::uint64_t>(status.lockouts), "lockout") + " since it started";
  return text;
}

std::string fault_line(const sync::Status& status) {
  if (status.fault == 0) return "none";
  return sync::fault_text(status.fault) + ": remove the cause, then glint sync clear";
}

std::string loss_line(const sync::Status& status) {
  std::string text = count_text(status.unsent, "report") + " not taken by the host";
  if (status.ignored_edges > 0)
    text += "; " + count_text(status.ignored_edges, "edge") + " at sync in came too soon";
  if (status.held_strobes > 0)
    text += "; " + count_text(status.held_strobes, "strobe") + " held back: please report this";
  return text;
}

std::string limit_line(const sync::Limits& limits) {
  return format_text(
      "strobes %.3f us and %.3g %% of the time at most; lockout above %.2f V, back below %.2f V",
      us(limits.strobe_max_width), limits.strobe_max_duty * 100.0, limits.lockout_v, limits.rearm_v);
}

std::string fixed_limit_line(const sync::Limits& limits) {
  return format_text("%.6g to %.6g Hz; pulses %.3f us, gaps between them %.3f us at least",
                     1.0 / limits.max_period.count(), 1.0 / limits.min_period.count(), us(limits.min_width),
                     us(limits.min_gap));
}

std::string first_frame_text(const RunOutcome& outcome) {
  switch (outcome.plan.start) {
    case sync::FrameStart::RisingEdge:
      return std::string("it waits for a rising edge at sync in (") + kSyncInPin + ")";
    case sync::FrameStart::FallingEdge:
      return std::string("it waits for a falling edge at sync in (") + kSyncInPin + ")";
    case sync::FrameStart::Internal:
      break;
  }
  if (!outcome.first_frame) return "its first frame was not seen";
  return "first frame " + format_text("%.3f ms", outcome.first_frame->count() * 1e3) + " after the command";
}

std::string applied_text(const RunOutcome& outcome) {
  const std::string from = outcome.applied_sequence
                               ? "from frame " + std::to_string(*outcome.applied_sequence) + " on"
                               : "as soon as a frame begins that is not planned yet";
  return format_text("run %d goes on, with the new settings ", outcome.run) + from;
}

}  // namespace

std::string output_pin(std::size_t output) { return "GP" + std::to_string(kFirstPin + output); }

std::string format_text(const char* format, ...) {
  char buffer[256];
  va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(buffer, sizeof buffer, format, arguments);
  va_end(arguments);
  return buffer;
}

std::string count_text(std::uint64_t count, const char* what) {
  return format_text("%llu %s%s", ull{count}, what, count == 1 ? "" : "s");
}

std::string board_line(const sync::Info& info) {
  return format_text("sync board %s, firmware %s (%s), protocol %d.%d\n", info.serial.c_str(),
                     info.firmware_text().c_str(), info.build.c_str(), info.protocol_major,
                     info.protocol_minor);
}

std::string status_text(const sync::Info& info, const sync::Status& status, const sync::Limits& limits,
                        const sync::BoardPlan& staged) {
  std::string started = sync::reset_text(status.reset_reason);
  if (status.after_watchdog) started += ": the firmware had hung";
  return board_line(info) + row("state", state_line(status)) + row("started by", started) +
         row("supply", supply_line(status, limits)) + row("fault", fault_line(status)) +
         row("losses", loss_line(status)) + row("limits", limit_line(limits)) +
         row("fixed", fixed_limit_line(limits)) + "staged settings\n" +
         plan_text(staged, staged, info.tick_hz);
}

std::string plan_text(const sync::BoardPlan& plan, const sync::BoardPlan& asked, std::uint32_t tick_hz) {
  std::string text = row("rate", frame_text(plan, asked, tick_hz)) + row("begin", begin_text(plan));
  if (plan.pulses > 0) text += row("pulses", count_text(plan.pulses, "frame") + ", then the run ends");
  if (plan.keepalive.count() > 0) {
    text += row("keep-alive",
                "the run ends after " + sync::time_text(plan.keepalive) + " without a word from the host");
  }
  if (plan.code.group > 0) text += row("code", code_text(plan.code));
  if (plan.sync_out) text += row("sync out", "repeats output 0 (GP15)");
  return text + outputs_text(plan, asked);
}

std::string limits_text(const sync::Limits& limits) {
  return row("limits", limit_line(limits)) + row("fixed", fixed_limit_line(limits));
}

std::string run_text(const RunOutcome& outcome, const sync::BoardPlan& asked, std::uint32_t tick_hz) {
  std::string text;
  switch (outcome.kind) {
    case RunOutcome::Kind::Started:
      text = format_text("run %d has started; ", outcome.run) + first_frame_text(outcome);
      break;
    case RunOutcome::Kind::Restarted:
      text = format_text(
                 "run %d was ended, for what begins frames, sync out and levels of triggers cannot change "
                 "in a run; run %d has started; ",
                 outcome.previous_run, outcome.run) +
             first_frame_text(outcome);
      break;
    case RunOutcome::Kind::Applied:
      text = applied_text(outcome);
      break;
  }
  text += "\n" + plan_text(outcome.plan, asked, tick_hz);
  if (outcome.supply_locked)
    text += "the supply of the lights is too high: STROBES ARE LOCKED OUT until it falls\n";
  if (outcome.plan.code.group > 0) {
    text += format_text("the rig file's [sync] section: code_seed = %u, code_group = %d\n",
                        outcome.plan.code.seed, outcome.plan.code.group);
  }
  return text;
}

std::string stopped_text(const StopOutcome& outcome) {
  if (!outcome.was_running) return "nothing was running\n";
  if (outcome.state == sync::RunState::Testing) return "the self-test has ended\n";
  return format_text("run %d has ended after ", outcome.status.run) +
         count_text(outcome.status.sequence, "frame") + "\n";
}

std::string change_text(const ChangeOutcome& outcome, std::size_t output, const sync::BoardPlan& asked,
                        std::uint32_t tick_hz) {
  if (outcome.run && outcome.run->kind != RunOutcome::Kind::Applied)
    return run_text(*outcome.run, asked, tick_hz);
  const std::string text =
      outcome.run ? applied_text(*outcome.run) + "\n"
                  : "staged; nothing runs: glint sync start (or --start here) begins a run with it\n";
  const sync::OutputPlan& changed = outcome.plan.outputs.at(output);
  if (!changed.enabled) return text + row("off", std::to_string(output));
  return text + kOutputHeader + output_row(output, changed, asked.outputs[output]);
}

}  // namespace glint::apps
