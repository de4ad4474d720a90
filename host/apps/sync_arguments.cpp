// SPDX-License-Identifier: MIT
// Words to values, and what of them fits together.
#include "host/apps/sync_arguments.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "host/base/error.hpp"
#include "host/base/pulse_code.hpp"

namespace glint::apps {
namespace {

struct Unit {
  std::string_view name;
  double seconds;
};
constexpr std::array<Unit, 6> kUnits{
    {{"ns", 1e-9}, {"us", 1e-6}, {"\u00b5s", 1e-6}, {"\u03bcs", 1e-6}, {"ms", 1e-3}, {"s", 1.0}}};

[[noreturn]] void refuse_outputs(const std::string& option, const std::string& text, std::size_t first,
                                 std::size_t last) {
  const std::string from = std::to_string(first), to = std::to_string(last);
  throw UsageError(option + " " + text + ": must be outputs " + from + " to " + to + ", like " + from + "," +
                   std::to_string(first + 1) + " or " + from + "-" + to + ", or none");
}

/// A number at the beginning of `text`, which is taken off it.
std::optional<std::size_t> take_number(std::string_view& text) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return std::nullopt;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return number;
}

std::chrono::milliseconds keepalive_of(const std::optional<sync::Seconds>& time) {
  if (!time) return std::chrono::milliseconds(0);
  const double ms = std::round(time->count() * 1e3);
  constexpr double kMost_ms = std::numeric_limits<std::uint16_t>::max();
  if (ms < 1.0 || ms > kMost_ms) throw UsageError("--keepalive must be 1ms to 65.535s");
  return std::chrono::milliseconds(static_cast<int>(ms));
}

sync::DarkCode code_of(const StartArguments& a, double rate_hz) {
  if (!a.code_seed) {
    if (a.code_group || a.code_dark_width)
      throw UsageError("--code-group and --code-dark-width go with --code");
    return {};
  }
  const std::uint32_t group = a.code_group.value_or(PulseCode::recommended_group(rate_hz));
  if (group < PulseCode::kLeastGroup || group > PulseCode::kMostGroup) {
    throw UsageError("--code-group " + std::to_string(group) + ": must be " +
                     std::to_string(PulseCode::kLeastGroup) + " to " + std::to_string(PulseCode::kMostGroup));
  }
  return {*a.code_seed, static_cast<int>(group), a.code_dark_width.value_or(sync::Seconds(0.0))};
}

/// Options that contradict the choice of outputs.
void check_outputs(const StartArguments& a, bool any_trigger, bool any_strobe) {
  if (!any_trigger && !any_strobe) throw UsageError("--triggers none --strobes none: nothing is left to run");
  if (any_strobe && !a.exposure) {
    throw UsageError(
        "--exposure is missing: how long the lights shine in each frame, like --exposure 137us; without "
        "lights: --strobes none");
  }
  if (!any_strobe && (a.exposure || a.strobe_delay || a.code_seed)) {
    throw UsageError("--exposure, --strobe-delay and --code are about lights, but --strobes says none");
  }
  if (!any_trigger && (a.trigger_width || a.trigger_delay)) {
    throw UsageError("--trigger-width and --trigger-delay are about triggers, but --triggers says none");
  }
}

}  // namespace

sync::Seconds parse_time(const std::string& text, const std::string& option) {
  double number = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  std::string_view unit(end, static_cast<std::size_t>(text.data() + text.size() - end));
  while (unit.starts_with(' ')) unit.remove_prefix(1);
  if (error != std::errc{} || !std::isfinite(number) || number < 0.0) {
    throw UsageError(option + " " + text + ": must be a time with its unit, like 8ns, 137us, 1.5ms or 2s");
  }
  for (const Unit& known : kUnits) {
    if (unit == known.name) return sync::Seconds(number * known.seconds);
  }
  if (unit.empty()) {
    throw UsageError(option + " " + text + ": the unit is missing; write " + text + "us, " + text + "ms or " +
                     text + "s");
  }
  throw UsageError(option + " " + text + ": unknown unit " + std::string(unit) +
                   "; there are ns, us, ms and s");
}

std::vector<std::size_t> parse_outputs(const std::string& text, const std::string& option, std::size_t first,
                                       std::size_t last) {
  std::vector<std::size_t> outputs;
  if (text == "none") return outputs;
  std::string_view rest = text;
  while (true) {
    const auto from = take_number(rest);
    auto to = from;
    if (rest.starts_with('-')) {
      rest.remove_prefix(1);
      to = take_number(rest);
    }
    if (!from || !to || *from < first || *to > last || *from > *to) refuse_outputs(option, text, first, last);
    for (std::size_t i = *from; i <= *to; ++i) {
      if (std::find(outputs.begin(), outputs.end(), i) == outputs.end()) outputs.push_back(i);
    }
    if (rest.empty()) return outputs;
    if (!rest.starts_with(',')) refuse_outputs(option, text, first, last);
    rest.remove_prefix(1);
  }
}

std::uint32_t parse_seed(const std::string& text) {
  if (text.empty()) return 1;
  std::uint32_t seed = 0;  // which in rig files means that there is no code
  const char* const last = text.data() + text.size();
  const auto [end, error] = std::from_chars(text.data(), last, seed);
  if (error != std::errc{} || end != last || seed == 0)
    throw UsageError("--code " + text + ": the seed must be 1 to 4294967295");
  return seed;
}

sync::FrameStart parse_edge(const std::string& text) {
  if (text == "rising") return sync::FrameStart::RisingEdge;
  if (text == "falling") return sync::FrameStart::FallingEdge;
  throw UsageError("--external " + text + ": must be rising or falling");
}

sync::BoardPlan plan_of(const StartArguments& a) {
  const double rate_hz = a.rate_hz.value_or(StartArguments::kDefaultRate_hz);
  if (!(rate_hz > 0.0) || !std::isfinite(rate_hz)) throw UsageError("--rate: must be above 0 Hz");
  if (a.pulses == 0u) throw UsageError("--pulses 0: must be 1 or more; without it the run does not end");
  const auto triggers = a.triggers.value_or(std::vector<std::size_t>{0, 1, 2, 3});
  const auto strobes = a.strobes.value_or(std::vector<std::size_t>{4, 5, 6, 7});
  check_outputs(a, !triggers.empty(), !strobes.empty());

  sync::BoardPlan plan;
  plan.start = a.external.value_or(sync::FrameStart::Internal);
  plan.period = sync::Seconds(1.0 / rate_hz);
  plan.pulses = a.pulses.value_or(0);
  plan.keepalive = keepalive_of(a.keepalive);
  plan.sync_out = a.sync_out;
  plan.code = code_of(a, rate_hz);

  const sync::Seconds none(0.0), usual_width(100e-6);
  for (std::size_t i = 0; i < sync::kOutputs; ++i) {
    const bool strobe = sync::is_strobe(i);
    const auto pair = static_cast<double>(strobe ? i - sync::kTriggers : i);
    sync::OutputPlan& output = plan.outputs[i];
    output.delay =
        (strobe ? a.strobe_delay : a.trigger_delay).value_or(none) + pair * a.interleave.value_or(none);
    output.width = (strobe ? a.exposure : a.trigger_width).value_or(usual_width);
  }
  for (const std::size_t i : triggers) plan.outputs[i].enabled = true;
  for (const std::size_t i : strobes) plan.outputs[i].enabled = true;
  if (a.sync_out && !plan.outputs[0].enabled)
    throw UsageError("--sync-out repeats output 0, which --triggers leaves out");
  return plan;
}

void set_strobe_level(sync::BoardPlan& plan, bool active_low) {
  for (std::size_t i = sync::kTriggers; i < sync::kOutputs; ++i) plan.outputs[i].active_low = active_low;
}

sync::BoardPlan changed_plan(sync::BoardPlan plan, const SetArguments& a, bool strobes_active_low) {
  sync::OutputPlan& output = plan.outputs.at(a.output);
  const std::string name = sync::output_name(a.output);
  if (a.on && a.off) throw UsageError(name + ": --on and --off exclude each other");
  if (a.active_low && a.active_high)
    throw UsageError(name + ": --active-low and --active-high exclude each other");
  if (a.on || a.off) output.enabled = a.on;
  if (a.active_low || a.active_high) {
    if (sync::is_strobe(a.output) && a.active_low != strobes_active_low) {
      throw UsageError(name + ": the jumper on the board makes strobes active " +
                       (strobes_active_low ? "low" : "high") + "; only the jumper changes that");
    }
    output.active_low = a.active_low;
  }
  if (a.delay) output.delay = *a.delay;
  if (a.width) output.width = *a.width;
  constexpr int kMostEvery = std::numeric_limits<std::uint8_t>::max();
  if (a.every) {
    if (*a.every < 1 || *a.every > kMostEvery) {
      throw UsageError(name + ": --every must be 1 (all frames) to " + std::to_string(kMostEvery));
    }
    output.every_n = *a.every;
  }
  if (a.phase) output.phase = *a.phase;
  if ((a.every || a.phase) && (output.phase < 0 || output.phase >= output.every_n)) {
    throw UsageError(name + ": --phase must be 0 to " + std::to_string(output.every_n - 1) +
                     " where it fires in every " + std::to_string(output.every_n) + ", not " +
                     std::to_string(output.phase));
  }
  return plan;
}

sync::Limits changed_limits(sync::Limits limits, const LimitArguments& a) {
  constexpr double kHysteresis_v = 0.2;
  if (a.lockout_v) {
    limits.lockout_v = *a.lockout_v;
    limits.rearm_v = std::min(limits.rearm_v, limits.lockout_v - kHysteresis_v);
  }
  if (a.rearm_v) limits.rearm_v = *a.rearm_v;
  if (a.strobe_duty_percent) limits.strobe_max_duty = *a.strobe_duty_percent * 1e-2;
  if (a.strobe_width) limits.strobe_max_width = *a.strobe_width;
  if (!(limits.rearm_v > 0.0 && limits.rearm_v < limits.lockout_v))
    throw UsageError("--rearm must be above 0 V and below --lockout");
  // The board counts in permille: what is less would be rounded to nothing.
  if (!(limits.strobe_max_duty >= 1e-3)) throw UsageError("--strobe-duty must be 0.1 % or more");
  return limits;
}

}  // namespace glint::apps
