// SPDX-License-Identifier: MIT
// Beginning, changing and ending a run of the sync board, and what came of it.
#pragma once

#include <cstdint>
#include <optional>

#include "usb-sync/board_plan.hpp"
#include "usb-sync/board_state.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint::apps {

/// What became of a plan that was to run.
struct RunOutcome {
  enum class Kind : std::uint8_t {
    Started,    ///< nothing ran before
    Applied,    ///< the run that was under way goes on with it
    Restarted,  ///< a run was under way, and had to end first
  };
  Kind kind = Kind::Started;
  sync::BoardPlan plan;        ///< on the board's grid
  int run = 0;                 ///< that runs now
  int previous_run = 0;        ///< Restarted: that ended
  bool supply_locked = false;  ///< strobes are held off for now
  /// From the command to the first frame; nothing where edges at sync in begin frames.
  std::optional<sync::Seconds> first_frame;
  /// Applied: the first frame with the new plan; nothing if it is still to come.
  std::optional<std::uint32_t> applied_sequence;
};

/// Runs what is staged on the board. If a run is under way, it takes the plan over on a frame boundary; if
/// that cannot be (what begins frames, sync out or the level of a trigger differs), it ends and another one
/// begins. Throws glint::Error if nothing is staged, and as SyncBoard.
RunOutcome run_staged(sync::SyncBoard& board);

/// Stages the plan and runs it. If the board refuses it, what was staged before is staged again.
RunOutcome run_plan(sync::SyncBoard& board, const sync::BoardPlan& plan);

struct ChangeOutcome {
  sync::BoardPlan plan;           ///< staged now, on the board's grid
  std::optional<RunOutcome> run;  ///< nothing: no run is under way, and none was begun
};

/// Stages the plan, and applies it to the run that is under way; never ends that one. If there is none,
/// begins one if `start_run` says so. If the board refuses the plan, what was staged before is staged again.
ChangeOutcome change_plan(sync::SyncBoard& board, const sync::BoardPlan& plan, bool start_run);

struct StopOutcome {
  bool was_running = false;
  sync::RunState state = sync::RunState::Idle;  ///< before
  sync::Status status;                          ///< after
};

/// Ends the run, after the frame that is under way, and waits for that.
StopOutcome stop_run(sync::SyncBoard& board);

/// Resets the board and waits until it is back. Throws glint::Error if it does not come.
sync::Info reset_board(sync::SyncBoard& board, sync::HidBus& bus);

}  // namespace glint::apps
