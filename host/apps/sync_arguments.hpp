// SPDX-License-Identifier: MIT
// What people write behind `glint sync`, as values: times, outputs, plans, limits.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "usb-sync/board_plan.hpp"
#include "usb-sync/board_state.hpp"

namespace glint::apps {

/// "8ns", "137us", "1.5 ms", "2s". Throws UsageError that names `option`, also where the unit is missing.
sync::Seconds parse_time(const std::string& text, const std::string& option);

/// "0,2", "4-7", "0-1,3", each number once and in the order written; "none" is empty. Throws UsageError that
/// names `option` unless all are `first` .. `last`.
std::vector<std::size_t> parse_outputs(const std::string& text, const std::string& option, std::size_t first,
                                       std::size_t last);

/// Of coded pulses: 1 to 4294967295; "" is 1. Throws UsageError.
std::uint32_t parse_seed(const std::string& text);

/// "rising", "falling". Throws UsageError.
sync::FrameStart parse_edge(const std::string& text);

/// `glint sync start`, as far as it is given.
struct StartArguments {
  static constexpr double kDefaultRate_hz = 90.0;

  std::optional<double> rate_hz;
  std::optional<sync::Seconds> exposure, strobe_delay, trigger_width, trigger_delay, interleave;
  std::optional<std::vector<std::size_t>> triggers, strobes;
  std::optional<std::uint32_t> pulses;
  std::optional<sync::FrameStart> external;
  std::optional<sync::Seconds> keepalive;
  bool sync_out = false;
  std::optional<std::uint32_t> code_seed;
  std::optional<std::uint32_t> code_group;
  std::optional<sync::Seconds> code_dark_width;

  /// Nothing is given: what is staged on the board shall run.
  bool empty() const { return *this == StartArguments{}; }
  bool operator==(const StartArguments&) const = default;
};

/// The whole plan; what is not given is as the help says. Strobes are active high: see set_strobe_level().
/// Throws UsageError.
sync::BoardPlan plan_of(const StartArguments& arguments);

/// Strobes are as the jumper on the board says: Info::strobes_active_low.
void set_strobe_level(sync::BoardPlan& plan, bool active_low);

/// `glint sync set`.
struct SetArguments {
  std::size_t output = 0;
  bool on = false, off = false, active_low = false, active_high = false;
  std::optional<sync::Seconds> delay, width;
  std::optional<int> every, phase;

  /// Nothing is to be changed.
  bool empty() const {
    SetArguments nothing;
    nothing.output = output;
    return *this == nothing;
  }
  bool operator==(const SetArguments&) const = default;
};

/// The plan with one output changed. `strobes_active_low` is Info's. Throws UsageError.
sync::BoardPlan changed_plan(sync::BoardPlan plan, const SetArguments& arguments, bool strobes_active_low);

/// `glint sync limits`.
struct LimitArguments {
  std::optional<double> lockout_v, rearm_v, strobe_duty_percent;
  std::optional<sync::Seconds> strobe_width;

  /// Nothing is to be changed.
  bool empty() const { return *this == LimitArguments{}; }
  bool operator==(const LimitArguments&) const = default;
};

/// Where only the lockout is given, the re-arm voltage goes down with it, 0.2 V below. Throws UsageError.
sync::Limits changed_limits(sync::Limits limits, const LimitArguments& arguments);

}  // namespace glint::apps
