// SPDX-License-Identifier: MIT
#include "host/sync/board_run.hpp"

#include <algorithm>
#include <chrono>

#include "firmware/protocol/sync_report.h"
#include "usb-sync/board_text.hpp"

namespace glint {
namespace {

using namespace std::chrono_literals;

// A second at the board's highest rate: the reader looks at every frame set, or five times a second.
constexpr std::size_t kRing = 2048;
constexpr std::chrono::milliseconds kListen{50};
// Until the clock model knows the board's clock well.
constexpr std::uint64_t kPulsesToSettle = 90;

std::string volts(std::uint32_t mv) {
  return std::to_string(mv / 1000) + "." + std::to_string(mv % 1000 / 100) + " V";
}

}  // namespace

BoardRun::BoardRun(const BoardRunOptions& options, sync::HidBus& bus)
    : options_(options), link_(options.serial, options.link, bus), info_(link_.info()), ring_(kRing) {
  std::optional<sync::Seconds> strobe, trigger;
  for (std::size_t i = 0; i < sync::kOutputs; ++i) {
    sync::OutputPlan& output = options_.plan.outputs[i];
    if (sync::is_strobe(i)) output.active_low = info_.strobes_active_low;  // nobody else decides that
    if (!output.enabled) continue;
    std::optional<sync::Seconds>& first = sync::is_strobe(i) ? strobe : trigger;
    if (!first) first = output.delay;
    if (sync::is_strobe(i)) strobes_ |= static_cast<std::uint8_t>(1u << i);
  }
  light_delay_ = strobe ? *strobe : trigger.value_or(sync::Seconds(0.0));
}

BoardRun::~BoardRun() { end(); }

void BoardRun::begin() {
  end();
  for (FiredPulse old; ring_.pop(old);) {
  }
  counting_ = false;
  if (options_.follow) {
    run_.reset();
  } else {
    start_board();
  }
  thread_ = std::jthread([this](const std::stop_token& stop) { listen(stop); });
}

void BoardRun::end() noexcept {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
  if (!options_.follow) stop_board();
}

void BoardRun::start_board() {
  sync::SyncBoard* const board = link_.board();
  if (board == nullptr)
    throw sync::BoardGone("the sync board " + info_.serial + " is gone: plug it in again");
  const sync::Status before = board->status();
  if (before.state != sync::RunState::Idle) board->end_run();
  if (before.fault != 0) board->clear_fault();
  options_.plan = board->start(options_.plan);
  run_ = static_cast<std::uint16_t>(board->status().run);
}

void BoardRun::stop_board() noexcept {
  try {
    if (sync::SyncBoard* const board = link_.board()) board->stop();
  } catch (const std::exception& error) {
    say(std::string("the sync board could not be stopped: ") + error.what());
  }
}

void BoardRun::listen(const std::stop_token& stop) noexcept {
  while (!stop.stop_requested()) {
    const sync::LinkUpdate update = link_.next(kListen);
    if (const auto* const trigger = std::get_if<sync::TimedTrigger>(&update)) {
      on_trigger(*trigger);
    } else if (const auto* const event = std::get_if<sync::TimedEvent>(&update)) {
      on_event(*event);
    } else if (std::holds_alternative<sync::LinkGone>(update)) {
      gone_.fetch_add(1, std::memory_order_relaxed);
      say("the sync board is gone: when pulses are fired is not known");
    } else if (const auto* const back = std::get_if<sync::LinkBack>(&update)) {
      on_back(back->was_reset);
    }
    if (restart_) restart();
  }
}

void BoardRun::on_trigger(const sync::TimedTrigger& timed) noexcept {
  if (run_ && timed.run != *run_) return;  // of a run before
  if (counting_ && timed.sequence > expected_)
    not_told_.fetch_add(timed.sequence - expected_, std::memory_order_relaxed);
  counting_ = true;
  expected_ = timed.sequence + 1;
  FiredPulse pulse;
  pulse.trigger = TriggerNo{timed.sequence};
  pulse.exposed = timed.begin.time + std::chrono::duration_cast<std::chrono::nanoseconds>(light_delay_);
  pulse.error_s = timed.begin.half_width.count();
  pulse.lights_on = strobes_ == 0 || (!timed.trigger.dark() && (timed.trigger.outputs & strobes_) != 0);
  const std::uint64_t before = pulses_.fetch_add(1, std::memory_order_relaxed);
  if (before >= kPulsesToSettle && pulse.error_s > worst_error_s_.load(std::memory_order_relaxed))
    worst_error_s_.store(pulse.error_s, std::memory_order_relaxed);
  if (!ring_.push(std::move(pulse))) not_taken_.fetch_add(1, std::memory_order_relaxed);
}

void BoardRun::on_event(const sync::TimedEvent& timed) noexcept {
  try {
    switch (timed.event.kind) {
      case sync::Event::Kind::Locked:
        lockouts_.fetch_add(1, std::memory_order_relaxed);
        say("the sync board keeps the lights off: their supply has " + volts(timed.event.detail));
        break;
      case sync::Event::Kind::Rearmed:
        say("the sync board lets the lights on again");
        break;
      case sync::Event::Kind::Stopped:
        if (run_ && timed.run != *run_) break;
        // The bus was reset, or this computer was too busy to be heard of: neither is a reason to stay dark.
        restart_ = !options_.follow && timed.event.stop_reason() == GLINT_SYNC_STOP_HOST_GONE;
        say("the sync board has stopped: " + (timed.event.stop_reason() == GLINT_SYNC_STOP_FAULT
                                                  ? sync::fault_text(timed.event.fault())
                                                  : sync::stop_text(timed.event.stop_reason())));
        break;
      default:
        break;
    }
  } catch (const std::bad_alloc&) {  // then it is not said
  }
}

void BoardRun::on_back(bool was_reset) noexcept {
  if (!was_reset) {
    restart_ = !options_.follow && link_.last_status().state == sync::RunState::Idle;
    return say("the sync board is back");
  }
  resets_.fetch_add(1, std::memory_order_relaxed);
  if (options_.follow) return say("the sync board is back, after a reset: nobody has started it yet");
  say("the sync board is back, after a reset");
  restart_ = true;
}

void BoardRun::restart() noexcept {
  if (link_.board() == nullptr) return;  // once it is back
  restart_ = false;
  try {
    start_board();
    counting_ = false;
    say("the sync board is started again");
  } catch (const std::exception& error) {
    say(std::string("the sync board cannot be started again: ") + error.what());
  }
}

void BoardRun::say(const std::string& text) const noexcept {
  if (options_.on_event) options_.on_event(text);
}

BoardCounters BoardRun::counters() const noexcept {
  BoardCounters counters;
  counters.pulses = pulses_.load(std::memory_order_relaxed);
  counters.not_told = not_told_.load(std::memory_order_relaxed);
  counters.not_taken = not_taken_.load(std::memory_order_relaxed);
  counters.gone = gone_.load(std::memory_order_relaxed);
  counters.resets = resets_.load(std::memory_order_relaxed);
  counters.lockouts = lockouts_.load(std::memory_order_relaxed);
  counters.worst_error_s = worst_error_s_.load(std::memory_order_relaxed);
  return counters;
}

}  // namespace glint
