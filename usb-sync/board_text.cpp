// SPDX-License-Identifier: MIT
#include "usb-sync/board_text.hpp"

#include <cstdio>

#include "usb-sync/board_plan.hpp"

namespace glint::sync {
namespace {

std::string number_text(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string wrong_state_text(RunState state) {
  switch (state) {
    case RunState::Idle:
      return "nothing runs on the board: start a run first";
    case RunState::Testing:
      return "the board is testing itself: wait until it is done";
    case RunState::Running:
    case RunState::Waiting:
      break;
  }
  return "that cannot be done or changed during a run: stop it first";
}

}  // namespace

const char* state_text(RunState state) noexcept {
  switch (state) {
    case RunState::Idle:
      return "idle";
    case RunState::Running:
      return "running";
    case RunState::Waiting:
      return "waiting for an edge at sync in";
    case RunState::Testing:
      return "testing itself";
  }
  return "unknown";
}

std::string stop_text(std::uint32_t stop_reason) {
  switch (stop_reason) {
    case GLINT_SYNC_STOP_COMMAND:
      return "it was told to";
    case GLINT_SYNC_STOP_BURST_END:
      return "all pulses are done";
    case GLINT_SYNC_STOP_HOST_GONE:
      return "its host was gone";
    case GLINT_SYNC_STOP_FAULT:
      return "of a fault";
    default:
      return "reason " + std::to_string(stop_reason);
  }
}

std::string fault_text(std::uint32_t fault) {
  switch (fault) {
    case GLINT_SYNC_FAULT_NONE:
      return "none";
    case GLINT_SYNC_FAULT_UNDERRUN:
      return "a pulse was not ready in time";
    case GLINT_SYNC_FAULT_STALLED:
      return "a pulse that was due did not begin";
    case GLINT_SYNC_FAULT_SUPPLY:
      return "the supply of the lights cannot be measured";
    default:
      return "fault " + std::to_string(fault);
  }
}

std::string reset_text(std::uint32_t reset_reason) {
  switch (reset_reason) {
    case GLINT_SYNC_RESET_POWER:
      return "power-up";
    case GLINT_SYNC_RESET_WATCHDOG:
      return "the watchdog";
    case GLINT_SYNC_RESET_COMMAND:
      return "a command";
    default:
      return "reset " + std::to_string(reset_reason);
  }
}

std::string refusal_text(const Status& status, std::uint32_t tick_hz) {
  const std::uint32_t limit = status.refusal_limit;
  const std::string number = std::to_string(limit);
  const std::string time = time_text(seconds_of(limit, tick_hz));
  const std::string rate = number_text("%.6g Hz", limit > 0 ? static_cast<double>(tick_hz) / limit : 0.0);
  const std::string where =
      status.refusal_output ? output_name(static_cast<std::size_t>(*status.refusal_output)) + ": " : "";
  const std::string volts = number_text("%.4g V", 1e-3 * limit), share = number_text("%.3g %%", 0.1 * limit);
  const char* const cap = ", which nobody can lift";
  switch (status.refusal) {
    case GLINT_SYNC_REFUSED_NOTHING:
      return "nothing was refused";
    case GLINT_SYNC_REFUSED_FORMAT:
      return where + "a value has no meaning to the board";
    case GLINT_SYNC_REFUSED_REPORT:
      return "the board does not know this setting: its firmware is older than this program, flash a newer "
             "one";
    case GLINT_SYNC_REFUSED_STATE:
      return wrong_state_text(status.state);
    case GLINT_SYNC_REFUSED_FAULT:
      return "a fault stands on the board (" + fault_text(status.fault) +
             "): remove its cause, then clear it";
    case GLINT_SYNC_REFUSED_MAGIC:
      return "the number that guards this command is wrong";
    case GLINT_SYNC_REFUSED_PERIOD_SHORT:
      return "the period is too short: the board can do " + time + " (" + rate + ") at least";
    case GLINT_SYNC_REFUSED_PERIOD_LONG:
      return "the period is too long: the board can do " + time + " (" + rate + ") at most";
    case GLINT_SYNC_REFUSED_DELAY:
      return where + "the delay must be below the period, " + time;
    case GLINT_SYNC_REFUSED_WIDTH_SHORT:
      return (where.empty() ? "dark frames: " : where) + "the pulse is too short: the least is " + time;
    case GLINT_SYNC_REFUSED_WIDTH_LONG:
      return where + "the pulse and the gap behind it do not fit into the period: at most " + time +
             " with this delay";
    case GLINT_SYNC_REFUSED_STROBE_WIDTH:
      return where.empty() ? "the longest pulse of light can be at most " + time + cap
                           : where + "the light may be on for at most " + time;
    case GLINT_SYNC_REFUSED_STROBE_DUTY:
      return where.empty() ? "lights can be on for at most " + share + " of the time" + cap
                           : where + "the light may be on for at most " + share +
                                 " of the time: shorten the pulse, or lower the rate";
    case GLINT_SYNC_REFUSED_POLARITY:
      if (!status.refusal_output || is_strobe(static_cast<std::size_t>(*status.refusal_output))) {
        return where + "the jumper on the board makes strobes active " + (limit != 0 ? "low" : "high") +
               ", and the plan says otherwise";
      }
      return where + "its active level cannot change during a run: stop it first";
    case GLINT_SYNC_REFUSED_PHASE:
      return where + "the phase must be below every_n, " + number;
    case GLINT_SYNC_REFUSED_CODE:
      return "the group of the dark code cannot be so: the nearest possible is " + number;
    case GLINT_SYNC_REFUSED_LOCKOUT:
      return "the lockout can be at most " + volts + cap;
    case GLINT_SYNC_REFUSED_REARM:
      return "the voltage for re-arming can be at most " + volts + ": 0.1 V below the lockout" + cap;
    case GLINT_SYNC_REFUSED_NO_OUTPUT:
      return "no output is switched on, or there is none with this number";
    case GLINT_SYNC_REFUSED_SUPPLY:
      return "the supply of the lights is too high (" + number_text("%.2f V", status.supply_v) +
             "): strobes are locked out until it falls";
    default:
      return where + "refused for a reason that this program does not know (" +
             std::to_string(status.refusal) + "): it is older than the board's firmware";
  }
}

}  // namespace glint::sync
