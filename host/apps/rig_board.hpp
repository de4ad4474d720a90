// SPDX-License-Identifier: MIT
// From the rig file's [sync] to the sync board that a run uses.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/config/rig.hpp"
#include "host/sync/board_run.hpp"

namespace glint::apps {

/// What the rig wants of its board.
sync::BoardPlan board_plan(const Rig& rig);

/// Opens the board; nullptr if the rig has none, or wants one only if it is there ("auto") and it is not,
/// which a note tells then. Throws sync::Error.
std::unique_ptr<BoardRun> open_board(const Rig& rig, std::vector<std::string>& notes,
                                     sync::HidBus& bus = sync::machine_hid_bus());

}  // namespace glint::apps
