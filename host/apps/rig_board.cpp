// SPDX-License-Identifier: MIT
#include "host/apps/rig_board.hpp"

#include "host/apps/live_cameras.hpp"
#include "host/base/pulse_code.hpp"

namespace glint::apps {
namespace {

sync::Seconds microseconds(double us) { return sync::Seconds(us * 1e-6); }

}  // namespace

sync::BoardPlan board_plan(const Rig& rig) {
  const SyncSettings& settings = rig.sync;
  sync::BoardPlan plan;
  plan.period = sync::Seconds(1.0 / rig.rate_hz);
  plan.keepalive = std::chrono::milliseconds(settings.keepalive_ms);
  plan.sync_out = settings.sync_out;
  if (settings.code_seed != 0) {
    plan.code.seed = settings.code_seed;
    plan.code.group = static_cast<int>(PulseCode::group_for(settings.code_group, rig.rate_hz));
  }
  for (std::size_t i = 0; i < sync::kOutputs; ++i) {
    sync::OutputPlan& output = plan.outputs[i];
    output.enabled = true;
    output.delay = microseconds(sync::is_strobe(i) ? settings.strobe_delay_us : settings.trigger_delay_us);
    output.width = microseconds(sync::is_strobe(i) ? settings.strobe_us : settings.trigger_us);
  }
  for (const SyncOutput& other : settings.outputs) {
    sync::OutputPlan& output = plan.outputs[other.output];
    output.enabled = other.enabled;
    output.active_low = other.active_low;
    if (other.delay_us) output.delay = microseconds(*other.delay_us);
    if (other.width_us) output.width = microseconds(*other.width_us);
    output.every_n = static_cast<int>(other.every_n);
    output.phase = static_cast<int>(other.phase);
  }
  return plan;
}

std::unique_ptr<BoardRun> open_board(const Rig& rig, std::vector<std::string>& notes, sync::HidBus& bus) {
  const std::string& wanted = rig.sync.board;
  if (wanted == "none") return nullptr;
  BoardRunOptions options;
  options.serial = wanted == "auto" ? "" : wanted;
  options.plan = board_plan(rig);
  options.follow = rig.sync.follow;
  options.on_event = print_event;
  try {
    auto board = std::make_unique<BoardRun>(options, bus);
    notes.push_back("sync board " + board->info().serial + ", firmware " + board->info().firmware_text() +
                    (options.follow ? ", followed" : ", started and stopped with this run"));
    return board;
  } catch (const sync::NoBoard&) {
    if (wanted != "auto") throw;
    notes.emplace_back(
        "no sync board is plugged in: frames are paired by their time stamps alone "
        "(sync.board = \"none\" in the rig file says that there is none)");
    return nullptr;
  }
}

}  // namespace glint::apps
