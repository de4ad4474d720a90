// SPDX-License-Identifier: MIT
// The sync boards that are plugged in, for `glint devices` and `glint doctor`.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "host/doctor/finding.hpp"
#include "usb-sync/hid_port.hpp"

namespace glint::apps {

/// A line for each board, "" without any.
std::string sync_boards_text(sync::HidBus& bus = sync::machine_hid_bus());
void add_sync_boards(nlohmann::ordered_json& json, sync::HidBus& bus = sync::machine_hid_bus());

/// May each board be used, does its firmware fit, is it well? Nothing without a board. `bootloaders`: places
/// where one waits to be flashed. `version`: this program's.
Findings check_sync_boards(sync::HidBus& bus, const std::vector<std::string>& bootloaders,
                           const std::string& version);
/// The same of this machine.
Findings check_sync_boards(const std::string& version);

}  // namespace glint::apps
