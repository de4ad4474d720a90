// SPDX-License-Identifier: MIT
// Commands to the board, and waiting for what they do.
#include "host/apps/sync_run.hpp"

#include <algorithm>
#include <string>
#include <thread>
#include <variant>

#include "host/base/error.hpp"
#include "usb-sync/error.hpp"

namespace glint::apps {
namespace {

using namespace std::chrono_literals;

/// Between two looks at the board.
constexpr auto kLook = 5ms;

bool under_way(sync::RunState state) {
  return state == sync::RunState::Running || state == sync::RunState::Waiting;
}

/// Asks for the status until `done` says so of it; nothing if that takes longer.
template <class Done>
std::optional<sync::Status> status_when(sync::SyncBoard& board, sync::Seconds longest, Done&& done) {
  const sync::HostTime deadline =
      sync::HostClock::now() + std::chrono::duration_cast<sync::HostClock::duration>(longest);
  while (true) {
    const sync::Status status = board.status();
    if (done(status)) return status;
    if (sync::HostClock::now() >= deadline) return std::nullopt;
    std::this_thread::sleep_for(kLook);
  }
}

/// When the first frame of that run was, or will be.
std::optional<std::uint64_t> first_tick(sync::SyncBoard& board, const sync::Status& status) {
  const sync::HostTime deadline = sync::HostClock::now() + 500ms;
  while (sync::HostClock::now() < deadline) {
    const sync::ReadResult read = board.read(50ms);
    if (read.kind == sync::ReadResult::Kind::Gone) break;
    const auto* event = std::get_if<sync::Event>(&read.report.content);
    if (read.kind == sync::ReadResult::Kind::Report && event != nullptr &&
        event->kind == sync::Event::Kind::Started && read.report.epoch == status.epoch &&
        read.report.run == status.run) {
      return event->tick;
    }
  }
  return std::nullopt;
}

RunOutcome start(sync::SyncBoard& board, const sync::BoardPlan& staged) {
  RunOutcome outcome;
  outcome.plan = staged;
  const auto asked = board.ask_time();
  board.start();
  const sync::Status status = board.status();
  outcome.run = status.run;
  outcome.supply_locked = status.supply_locked;
  if (staged.start != sync::FrameStart::Internal || !asked) return outcome;
  if (const auto tick = first_tick(board, status); tick && *tick > asked->tick)
    outcome.first_frame = sync::seconds_of(*tick - asked->tick, board.info().tick_hz);
  return outcome;
}

/// The new plan takes effect where the next frame is not planned yet: after one or two old periods, or after
/// the next edge at sync in.
RunOutcome apply(sync::SyncBoard& board, const sync::BoardPlan& staged) {
  constexpr sync::Seconds kLongest = 500ms;
  const std::uint32_t before = board.status().applied_sequence;
  board.apply();
  const auto status = status_when(
      board, kLongest, [before](const sync::Status& now) { return now.applied_sequence != before; });
  const sync::Status now = status ? *status : board.status();
  RunOutcome outcome;
  outcome.plan = staged;
  outcome.kind = RunOutcome::Kind::Applied;
  outcome.run = now.run;
  outcome.supply_locked = now.supply_locked;
  if (status) outcome.applied_sequence = status->applied_sequence;
  return outcome;
}

/// The plan is right, but only another run can take it.
bool needs_another_run(const sync::Refused& refused) {
  if (refused.reason() == GLINT_SYNC_REFUSED_STATE) return true;
  return refused.reason() == GLINT_SYNC_REFUSED_POLARITY && refused.output() &&
         !sync::is_strobe(static_cast<std::size_t>(*refused.output()));
}

RunOutcome run(sync::SyncBoard& board, const sync::BoardPlan& staged) {
  const sync::Status status = board.status();
  if (!under_way(status.state)) return start(board, staged);
  try {
    return apply(board, staged);
  } catch (const sync::Refused& refused) {
    if (!needs_another_run(refused)) throw;
  }
  board.end_run();
  try {
    RunOutcome outcome = start(board, staged);
    outcome.kind = RunOutcome::Kind::Restarted;
    outcome.previous_run = status.run;
    return outcome;
  } catch (const sync::Refused& refused) {
    throw sync::Refused(std::string(refused.what()) + "; run " + std::to_string(status.run) +
                            " had to end before, and glint sync start begins its like",
                        refused.reason(), refused.output());
  }
}

/// Stages the plan; if `work` with what the board makes of it is refused, stages the old one again.
template <class Work>
auto with_staged(sync::SyncBoard& board, const sync::BoardPlan& plan, Work&& work) {
  const sync::BoardPlan before = board.staged();
  try {
    return work(board.stage(plan));
  } catch (const sync::Refused&) {
    board.stage(before);
    throw;
  }
}

}  // namespace

RunOutcome run_staged(sync::SyncBoard& board) {
  const sync::BoardPlan plan = board.staged();
  if (std::none_of(plan.outputs.begin(), plan.outputs.end(),
                   [](const sync::OutputPlan& output) { return output.enabled; })) {
    throw Error(
        "the sync board was not told yet what to do: glint sync start --rate 90 --exposure 137us, for "
        "example");
  }
  return run(board, plan);
}

RunOutcome run_plan(sync::SyncBoard& board, const sync::BoardPlan& plan) {
  return with_staged(board, plan, [&board](const sync::BoardPlan& staged) { return run(board, staged); });
}

ChangeOutcome change_plan(sync::SyncBoard& board, const sync::BoardPlan& plan, bool start_run) {
  return with_staged(board, plan, [&](const sync::BoardPlan& staged) {
    ChangeOutcome outcome;
    outcome.plan = staged;
    if (under_way(board.status().state)) {
      outcome.run = apply(board, staged);
    } else if (start_run) {
      outcome.run = start(board, staged);
    }
    return outcome;
  });
}

StopOutcome stop_run(sync::SyncBoard& board) {
  StopOutcome outcome;
  outcome.state = board.status().state;
  outcome.was_running = outcome.state != sync::RunState::Idle;
  outcome.status = board.end_run();
  return outcome;
}

sync::Info reset_board(sync::SyncBoard& board, sync::HidBus& bus) {
  constexpr auto kLongest = 10s;
  const sync::Info before = board.info();
  board.reset();
  const sync::HostTime deadline = sync::HostClock::now() + kLongest;
  std::string trouble = "it is not on the bus";
  while (sync::HostClock::now() < deadline) {
    try {
      const sync::SyncBoard again = sync::SyncBoard::open(before.serial, bus);
      if (again.info().epoch != before.epoch) return again.info();
      trouble = "it has not reset itself";
    } catch (const sync::Error& error) {  // not there yet, or udev has not given permission yet
      trouble = error.what();
    }
    std::this_thread::sleep_for(50ms);
  }
  throw Error("sync board " + before.serial + " did not come back after the reset (" + trouble +
              "): plug it in again");
}

}  // namespace glint::apps
