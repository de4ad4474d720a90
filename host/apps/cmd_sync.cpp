// SPDX-License-Identifier: MIT
// `glint sync`: the sync board from the command line.
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include "host/apps/commands.hpp"
#include "host/apps/progress_line.hpp"
#include "host/apps/stop_signal.hpp"
#include "host/apps/sync_arguments.hpp"
#include "host/apps/sync_flash.hpp"
#include "host/apps/sync_json.hpp"
#include "host/apps/sync_run.hpp"
#include "host/apps/sync_selftest.hpp"
#include "host/apps/sync_text.hpp"
#include "host/apps/sync_watch_output.hpp"
#include "host/base/error.hpp"
#include "usb-sync/board_text.hpp"

namespace glint::apps {
namespace {

using Json = nlohmann::ordered_json;

/// What all subcommands take.
struct BoardArguments {
  std::string serial;
  bool json = false;

  sync::SyncBoard open() const { return sync::SyncBoard::open(serial); }
};

void print(const std::string& text) {
  if (std::fwrite(text.data(), 1, text.size(), stdout) != text.size() || std::fflush(stdout) != 0)
    throw Error("standard output: cannot be written");
}

void print_json(const Json& json) { print(json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"); }

template <class Arguments>
struct Command {
  CLI::App* app;
  std::shared_ptr<Arguments> arguments;
};

/// A subcommand of `glint sync` with the options that all take.
template <class Arguments>
Command<Arguments> add_command(CLI::App& sync_app, const std::string& name, const std::string& help,
                               bool with_json = true) {
  Command<Arguments> command{sync_app.add_subcommand(name, help), std::make_shared<Arguments>()};
  command.app
      ->add_option("--board", command.arguments->serial, "serial number, where there are several boards")
      ->type_name("SERIAL");
  if (with_json) command.app->add_flag("--json", command.arguments->json, "as JSON");
  return command;
}

void add_status(CLI::App& sync_app) {
  const auto [app, a] = add_command<BoardArguments>(sync_app, "status", "All that the board says of itself");
  app->alias("info");
  app->callback([a = a] {
    sync::SyncBoard board = a->open();
    const sync::Status status = board.status();
    const sync::Limits limits = board.limits();
    const sync::BoardPlan staged = board.staged();
    if (!a->json) return print(status_text(board.info(), status, limits, staged));
    print_json(Json{{"info", info_json(board.info())},
                    {"status", status_json(status)},
                    {"limits", limits_json(limits)},
                    {"staged", plan_json(staged, board.info().tick_hz)}});
  });
}

/// An option that is a time with its unit.
void add_time(CLI::App& app, const std::string& name, std::optional<sync::Seconds>& time,
              const std::string& help) {
  app.add_option_function<std::string>(
         name, [&time, name](const std::string& text) { time = parse_time(text, name); }, help)
      ->type_name("TIME");
}

/// An option that is a list of outputs.
void add_outputs(CLI::App& app, const std::string& name, std::optional<std::vector<std::size_t>>& outputs,
                 std::size_t first, std::size_t last, const std::string& help) {
  app.add_option_function<std::string>(
         name,
         [&outputs, name, first, last](const std::string& text) {
           outputs = parse_outputs(text, name, first, last);
         },
         help)
      ->type_name("LIST");
}

struct StartCommand : BoardArguments {
  StartArguments plan;
};

void start(const StartCommand& a) {
  std::optional<sync::BoardPlan> asked;
  if (!a.plan.empty()) asked = plan_of(a.plan);
  sync::SyncBoard board = a.open();
  if (asked) set_strobe_level(*asked, board.info().strobes_active_low);
  const RunOutcome outcome = asked ? run_plan(board, *asked) : run_staged(board);
  const std::uint32_t tick_hz = board.info().tick_hz;
  if (a.json) return print_json(run_json(outcome, tick_hz));
  print(run_text(outcome, asked.value_or(outcome.plan), tick_hz));
}

void add_start(CLI::App& sync_app) {
  const auto [app, a] = add_command<StartCommand>(sync_app, "start",
                                                  "Begin a run, or give the one under way new settings "
                                                  "without a wrong pulse; without options: with what is "
                                                  "staged");
  StartArguments& p = a->plan;
  app->footer("Times have a unit: 8ns, 137us, 1.5ms, 2s. With any option, those left out are as said above.");
  app->add_option("--rate", p.rate_hz,
                  "frames per second, Hz; with --external the most that edges may begin. Default: 90");
  add_time(*app, "--exposure", p.exposure,
           "how long lights shine in each frame (with pulsed light that is the exposure)");
  add_time(*app, "--strobe-delay", p.strobe_delay, "from the beginning of a frame to its light. Default: 0s");
  add_time(*app, "--trigger-width", p.trigger_width, "length of the cameras' pulse. Default: 100us");
  add_time(*app, "--trigger-delay", p.trigger_delay, "from the beginning of a frame to it. Default: 0s");
  add_time(*app, "--interleave", p.interleave,
           "each trigger and its strobe that much later than those before. Default: 0s");
  add_outputs(*app, "--triggers", p.triggers, 0, sync::kTriggers - 1,
              "of outputs 0 to 3, like 0,2 or 0-1, or none. Default: 0-3");
  add_outputs(*app, "--strobes", p.strobes, sync::kTriggers, sync::kOutputs - 1,
              "of outputs 4 to 7, or none. Default: 4-7");
  app->add_option("--pulses", p.pulses,
                  "frames after which the run ends; 1: a single shot. Default: it does not end");
  app->add_option_function<std::string>(
         "--external", [&p](const std::string& text) { p.external = parse_edge(text); },
         "edges at sync in begin frames: rising or falling")
      ->type_name("EDGE");
  add_time(*app, "--keepalive", p.keepalive,
           "the run ends when the host was silent for so long; glint sync watch is not. Default: it goes on");
  app->add_flag("--sync-out", p.sync_out, "sync out repeats output 0");
  app->add_option_function<std::string>(
         "--code", [&p](const std::string& text) { p.code_seed = parse_seed(text); },
         "coded pulses: lights stay off in frames that follow from this seed. Default seed: 1")
      ->type_name("[SEED]")
      ->expected(0, 1);
  app->add_option("--code-group", p.code_group,
                  "one dark frame in so many, 18 to 1024. Default: less than half a second between two");
  add_time(*app, "--code-dark-width", p.code_dark_width, "shorten the light of dark frames to this instead");
  app->callback([a = a] { start(*a); });
}

void add_stop(CLI::App& sync_app) {
  const auto [app, a] =
      add_command<BoardArguments>(sync_app, "stop", "End the run, after the frame under way", false);
  app->callback([a = a] {
    sync::SyncBoard board = a->open();
    print(stopped_text(stop_run(board)));
  });
}

struct SetCommand : BoardArguments {
  SetArguments change;
  bool start = false;
};

void set(const SetCommand& a) {
  if (a.change.empty()) throw UsageError("glint sync set: say what to change, like --width 137us or --off");
  sync::SyncBoard board = a.open();
  const sync::BoardPlan asked = changed_plan(board.staged(), a.change, board.info().strobes_active_low);
  const ChangeOutcome outcome = change_plan(board, asked, a.start);
  const std::uint32_t tick_hz = board.info().tick_hz;
  if (!a.json) return print(change_text(outcome, a.change.output, asked, tick_hz));
  print_json(outcome.run ? run_json(*outcome.run, tick_hz)
                         : Json{{"outcome", "staged"}, {"plan", plan_json(outcome.plan, tick_hz)}});
}

void add_set(CLI::App& sync_app) {
  const auto [app, a] = add_command<SetCommand>(
      sync_app, "set", "Change one output, of the run that is under way or of the next");
  SetArguments& c = a->change;
  app->add_option("OUTPUT", c.output, "0 to 3: triggers; 4 to 7: strobes")
      ->required()
      ->check(CLI::Range(0u, 7u));
  app->add_flag("--on", c.on, "let it fire");
  app->add_flag("--off", c.off, "do not");
  add_time(*app, "--delay", c.delay, "from the beginning of a frame to its pulse, like 788us");
  add_time(*app, "--width", c.width, "length of its pulse, like 137us");
  app->add_option("--every", c.every, "fire in one frame of so many, 1 to 255");
  app->add_option("--phase", c.phase, "in which of them, from 0");
  app->add_flag("--active-low", c.active_low, "low while active; of triggers only, and not during a run");
  app->add_flag("--active-high", c.active_high, "high while active");
  app->add_flag("--start", a->start, "begin a run if there is none");
  app->callback([a = a] { set(*a); });
}

struct LimitsCommand : BoardArguments {
  LimitArguments change;
};

void add_limits(CLI::App& sync_app) {
  const auto [app, a] = add_command<LimitsCommand>(
      sync_app, "limits", "Show what protects the lights, or make it stricter until the board is reset");
  LimitArguments& c = a->change;
  app->add_option("--lockout", c.lockout_v, "strobes go off above this supply, volts");
  app->add_option("--rearm", c.rearm_v,
                  "and come back below this one, volts. Default: 0.2 V below --lockout");
  add_time(*app, "--strobe-width", c.strobe_width, "longest pulse of light");
  app->add_option("--strobe-duty", c.strobe_duty_percent, "share of time that a light may be on, percent");
  app->callback([a = a] {
    sync::SyncBoard board = a->open();
    sync::Limits limits = board.limits();
    if (!a->change.empty()) limits = board.set_limits(changed_limits(limits, a->change));
    if (a->json) return print_json(limits_json(limits));
    print(limits_text(limits));
  });
}

struct WatchCommand : BoardArguments {
  WatchOptions options;
};

void add_watch(CLI::App& sync_app) {
  const auto [app, a] = add_command<WatchCommand>(
      sync_app, "watch", "Say every second how the board is, and what happens; Ctrl-C ends it");
  app->add_option("--seconds", a->options.seconds, "end by itself after so long")
      ->check(CLI::Range(0.1, 1e9));
  app->callback([a = a] {
    StopSignal stop_signal;
    std::atomic<bool> stop = false;
    sync::BoardLink link(a->serial);
    const StopSignal::Handler on_stop(stop_signal, [&stop] { stop = true; });
    watch(link, *(a->json ? make_json_sink(stdout) : make_text_sink(stdout)), a->options, stop);
  });
}

struct SelfTestCommand : BoardArguments {
  std::vector<std::size_t> outputs;
  bool no_prompt = false;
};

void self_test(const SelfTestCommand& a) {
  sync::SyncBoard board = a.open();
  SelfTestOptions options;
  options.outputs = a.outputs;
  options.wait_for_wires = !a.no_prompt;
  for (std::size_t i = 0; a.outputs.empty() && i < sync::kOutputs; ++i) options.outputs.push_back(i);
  if (options.wait_for_wires && !a.json) {
    print(std::string("One wire from the output's pin to ") + kSyncInPin +
          " is enough: move it when you are asked to. Lights that are connected flash.\n");
  }
  const auto results = run_self_tests(board, options, [&a](const std::string& line) {
    if (!a.json) print(line + "\n");
  });
  if (a.json) {
    Json all = Json::array();
    for (const sync::SelfTestResult& result : results) all.push_back(selftest_json(result));
    print_json(all);
  }
  if (const std::string verdict = self_test_verdict(results, !a.outputs.empty() || !a.no_prompt);
      !verdict.empty())
    throw Error(verdict);
}

void add_selftest(CLI::App& sync_app) {
  const auto [app, a] = add_command<SelfTestCommand>(
      sync_app, "selftest", "Measure the pulses of outputs that are wired to sync in, one after the other");
  app->add_option("OUTPUT", a->outputs, "which, 0 to 7. Default: all")->check(CLI::Range(0u, 7u));
  app->add_flag("--no-prompt", a->no_prompt, "test once what is wired now");
  app->callback([a = a] {
    if (a->json && !a->no_prompt) throw UsageError("glint sync selftest: --json goes with --no-prompt");
    self_test(*a);
  });
}

struct FlashCommand : BoardArguments {
  FlashOptions options;
  bool yes = false;
};

/// Asks and tells on the terminal.
class FlashTerminal final : public FlashObserver {
 public:
  explicit FlashTerminal(const FlashCommand& command) : command_(command) {}

  bool confirm(const sync::Info& board) override {
    if (command_.yes) return true;
    if (isatty(STDIN_FILENO) != 1) throw UsageError("glint sync flash: add --yes where nobody can be asked");
    print(board_line(board) + "replace its firmware by " + command_.options.file + "? [y/N] ");
    const int answer = std::getchar();
    return answer == 'y' || answer == 'Y';
  }

  void progress(const std::string& text) override {
    if (!line_) line_.emplace(false);
    line_->show(text);
  }

  void clear() { line_.reset(); }

 private:
  const FlashCommand& command_;
  std::optional<ProgressLine> line_;
};

void flash(const FlashCommand& a) {
  FlashTerminal terminal(a);
  const auto outcome = flash_board(a.options, terminal, sync::machine_hid_bus(), machine_bootloaders());
  terminal.clear();
  if (!outcome) return print("nothing was changed\n");
  print(board_line(outcome->after));
  if (outcome->before)
    print("before: firmware " + outcome->before->firmware_text() + " (" + outcome->before->build + ")\n");
}

void add_flash(CLI::App& sync_app) {
  const auto [app, a] = add_command<FlashCommand>(
      sync_app, "flash",
      "Put firmware onto a board that waits in its bootloader, or else onto the one that runs", false);
  app->add_option("FILE", a->options.file, "firmware, .uf2")->required();
  app->add_option("--place", a->options.place, "of the bootloader, where there are several, like 1-4.2");
  app->add_flag("--yes", a->yes, "do not ask");
  app->add_flag("--force", a->options.force, "also while a run is under way");
  app->callback([a = a] {
    a->options.serial = a->serial;
    flash(*a);
  });
}

void add_clear(CLI::App& sync_app) {
  const auto [app, a] =
      add_command<BoardArguments>(sync_app, "clear", "Clear the fault, so that runs can begin again", false);
  app->callback([a = a] {
    sync::SyncBoard board = a->open();
    const std::uint8_t fault = board.status().fault;
    board.clear_fault();
    print(fault == 0 ? "no fault stood\n" : "cleared: " + sync::fault_text(fault) + "\n");
  });
}

void add_reset(CLI::App& sync_app) {
  const auto [app, a] = add_command<BoardArguments>(
      sync_app, "reset", "Restart the board: ends the run, and forgets settings and limits", false);
  app->callback([a = a] {
    sync::SyncBoard board = a->open();
    print("reset; " + board_line(reset_board(board, sync::machine_hid_bus())));
  });
}

}  // namespace

void add_sync(CLI::App& app) {
  CLI::App* sync_app = app.add_subcommand("sync", "Drive the sync board: triggers of cameras, lights");
  sync_app->require_subcommand(1);
  add_status(*sync_app);
  add_start(*sync_app);
  add_stop(*sync_app);
  add_set(*sync_app);
  add_limits(*sync_app);
  add_watch(*sync_app);
  add_selftest(*sync_app);
  add_flash(*sync_app);
  add_clear(*sync_app);
  add_reset(*sync_app);
}

}  // namespace glint::apps
