// SPDX-License-Identifier: MIT
// The sync board in JSON. Times are in microseconds, as people set them; SI otherwise.
#pragma once

#include <cstdint>

#include <nlohmann/json.hpp>

#include "host/apps/sync_run.hpp"
#include "usb-sync/board_plan.hpp"
#include "usb-sync/board_state.hpp"

namespace glint::apps {

/// "idle", "running", "waiting", "testing".
const char* state_key(sync::RunState state);

nlohmann::ordered_json info_json(const sync::Info& info);
nlohmann::ordered_json status_json(const sync::Status& status);
nlohmann::ordered_json limits_json(const sync::Limits& limits);
/// The plan as it is on the board's grid, outputs that are off included.
nlohmann::ordered_json plan_json(const sync::BoardPlan& plan, std::uint32_t tick_hz);
nlohmann::ordered_json run_json(const RunOutcome& outcome, std::uint32_t tick_hz);
nlohmann::ordered_json selftest_json(const sync::SelfTestResult& result);

}  // namespace glint::apps
