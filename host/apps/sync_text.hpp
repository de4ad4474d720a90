// SPDX-License-Identifier: MIT
// The sync board in words: who it is, how it is, what it is set to, what became of a command.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "host/apps/sync_run.hpp"
#include "usb-sync/board_plan.hpp"
#include "usb-sync/board_state.hpp"

namespace glint::apps {

/// Where sync in is on the board.
inline constexpr const char* kSyncInPin = "GP14";
/// Where an output is: "GP2" to "GP9".
std::string output_pin(std::size_t output);

/// printf() into a string of at most 255 characters.
__attribute__((format(printf, 1, 2))) std::string format_text(const char* format, ...);

/// "1 frame", "2 frames".
std::string count_text(std::uint64_t count, const char* what);

// All of these end with a line break.

/// "sync board E66..., firmware 0.1.0 (abc), protocol 1.0".
std::string board_line(const sync::Info& info);
/// Everything that the board says of itself.
std::string status_text(const sync::Info& info, const sync::Status& status, const sync::Limits& limits,
                        const sync::BoardPlan& staged);
/// `plan` is on the board's grid; where it is not what was `asked` for, that is said, too.
std::string plan_text(const sync::BoardPlan& plan, const sync::BoardPlan& asked, std::uint32_t tick_hz);
std::string limits_text(const sync::Limits& limits);
/// What a start came to: its plan, and the first frame.
std::string run_text(const RunOutcome& outcome, const sync::BoardPlan& asked, std::uint32_t tick_hz);
std::string stopped_text(const StopOutcome& outcome);
/// What a change of one output came to.
std::string change_text(const ChangeOutcome& outcome, std::size_t output, const sync::BoardPlan& asked,
                        std::uint32_t tick_hz);

}  // namespace glint::apps
