// SPDX-License-Identifier: MIT
// What the board's numbers mean, in plain words.
#pragma once

#include <cstdint>
#include <string>

#include "usb-sync/board_state.hpp"

namespace glint::sync {

/// "idle", "running", "waiting for an edge at sync in", "testing itself".
const char* state_text(RunState state) noexcept;

// Numbers of newer firmware are named as such: "reason 9".

/// glint_sync_stop: "its host was gone".
std::string stop_text(std::uint32_t stop_reason);
/// glint_sync_fault: "a pulse was not ready in time".
std::string fault_text(std::uint32_t fault);
/// glint_sync_reset: "the watchdog".
std::string reset_text(std::uint32_t reset_reason);

/// Why the board refused its last setting: which output, which limit in its unit, what to do.
std::string refusal_text(const Status& status, std::uint32_t tick_hz);

}  // namespace glint::sync
