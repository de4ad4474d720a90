// SPDX-License-Identifier: MIT
// The loop around BoardLink, and its figures.
#include "host/apps/sync_watch.hpp"

#include <algorithm>
#include <variant>

#include "host/apps/sync_text.hpp"
#include "usb-sync/board_text.hpp"

namespace glint::apps {
namespace {

using Event = sync::Event;

DelayFigures figures_of(const LatencyHistogram& delays) {
  return {delays.count(), delays.quantile_s(0.5), delays.quantile_s(0.99), delays.max_s()};
}

std::string stopped_event_text(const Event& event) {
  std::string text = "ended after " + count_text(event.sequence, "frame") + " because " +
                     sync::stop_text(event.stop_reason());
  if (event.fault() != 0) text += ": " + sync::fault_text(event.fault());
  return text;
}

std::string volts(std::uint32_t mv) { return format_text("%.2f V", 1e-3 * mv); }

/// One watch: what it knows beside the link.
class Watch {
 public:
  Watch(sync::BoardLink& link, WatchSink& sink) : link_(link), sink_(sink), status_(link.last_status()) {
    note_supply(status_.supply_v);
  }

  void run(const WatchOptions& options, const std::atomic<bool>& stop) {
    constexpr std::chrono::milliseconds kLook{50};  // at `stop`
    sink_.begin(link_.info());
    if (status_.fault != 0) tell("fault", "a fault stands on the board: " + sync::fault_text(status_.fault));
    sync::HostTime due = start_ + options.update_period;
    while (!stop && !(options.seconds && since_start_s() >= *options.seconds)) {
      take(link_.next(kLook));
      if (sync::HostClock::now() < due) continue;
      update();
      due = std::max(due + options.update_period, sync::HostClock::now());
    }
    sink_.end(summary());
  }

 private:
  double since_start_s() const { return sync::Seconds(sync::HostClock::now() - start_).count(); }

  void note_supply(double volts) {
    supply_v_ = volts;
    if (!(volts > 0.0)) return;  // not measured yet
    least_supply_v_ = least_supply_v_ > 0.0 ? std::min(least_supply_v_, volts) : volts;
    most_supply_v_ = std::max(most_supply_v_, volts);
  }

  void tell(const char* kind, std::string text) {
    WatchEvent event;
    event.kind = kind;
    event.text = std::move(text);
    tell(std::move(event));
  }
  void tell(WatchEvent event) {
    event.since_start_s = since_start_s();
    sink_.event(event);
  }

  void take(const sync::LinkUpdate& update) {
    if (const auto* trigger = std::get_if<sync::TimedTrigger>(&update)) {
      take(*trigger);
    } else if (const auto* event = std::get_if<sync::TimedEvent>(&update)) {
      note_supply(1e-3 * event->supply_mv);
      tell(event_of(*event));
    } else if (std::holds_alternative<sync::LinkGone>(update)) {
      tell("gone", "the board does not answer any more: unplugged, reset or hung; it is being looked for");
    } else if (const auto* back = std::get_if<sync::LinkBack>(&update)) {
      if (back->was_reset) newest_tick_ = 0;
      tell("back", back->was_reset ? "the board is back, after a reset: nothing runs on it"
                                   : "the board is back and went on meanwhile");
    } else if (const auto* lost = std::get_if<sync::ReportsLost>(&update)) {
      tell("lost", count_text(lost->count, "report") + " lost for good");
    }
    tell_trouble();
  }

  void take(const sync::TimedTrigger& trigger) {
    statistics_.add(trigger);
    note_supply(1e-3 * trigger.supply_mv);
    newest_tick_ = trigger.trigger.tick;
    const std::uint64_t reports = link_.counters().reports;
    if (reports != reports_) statistics_.add_delay(link_.last_report_delay().count());
    reports_ = reports;
  }

  /// What the link has noticed by the way.
  void tell_trouble() {
    if (link_.reopen_trouble() != trouble_) {
      trouble_ = link_.reopen_trouble();
      if (!trouble_.empty()) tell("trouble", trouble_);
    }
  }

  /// At most once an update: where it happens, it may happen often.
  void tell_clock() {
    const std::uint64_t all = link_.clock().contradictions();
    if (all == contradictions_) return;
    contradictions_ = all;
    tell("clock", "the clocks of board and host ran apart (was the computer asleep?) and were matched anew");
  }

  void update() {
    tell_clock();
    if (sync::SyncBoard* board = link_.board()) {
      if (const auto status = board->try_status()) {
        status_ = *status;
        note_supply(status_.supply_v);
        newest_tick_ = std::max(newest_tick_, status_.now_tick);
      }
    }
    WatchUpdate update;
    update.since_start_s = since_start_s();
    update.present = link_.board() != nullptr;
    update.trouble = link_.reopen_trouble();
    update.state = status_.state;
    update.run = status_.run;
    update.fault = status_.fault;
    update.supply_locked = status_.supply_locked;
    update.supply_v = supply_v_;
    update.window = statistics_.take_window(link_.info().tick_hz);
    update.counters = link_.counters();
    if (update.present) {
      if (const auto now = link_.clock().at(newest_tick_)) update.clock_bound_s = now->half_width.count();
    }
    sink_.update(update);
  }

  WatchSummary summary() const {
    return {since_start_s(), statistics_.frames(), statistics_.all_delays(), link_.counters(),
            least_supply_v_, most_supply_v_,       contradictions_};
  }

  sync::BoardLink& link_;
  WatchSink& sink_;
  const sync::HostTime start_ = sync::HostClock::now();
  sync::Status status_;
  WatchStatistics statistics_;
  double supply_v_ = 0.0, least_supply_v_ = 0.0, most_supply_v_ = 0.0;
  std::uint64_t newest_tick_ = 0;
  std::uint64_t reports_ = 0;
  std::uint64_t contradictions_ = 0;
  std::string trouble_;
};

}  // namespace

void WatchStatistics::add(const sync::TimedTrigger& trigger) noexcept {
  const Mark mark{trigger.epoch, trigger.run, trigger.sequence, trigger.trigger.tick};
  ++frames_.seen;
  ++window_frames_;
  if (trigger.trigger.dark()) ++frames_.dark;
  if (trigger.trigger.locked()) ++frames_.locked;
  if (trigger.trigger.held()) ++frames_.held;
  const bool same_run = last_ && last_->epoch == mark.epoch && last_->run == mark.run;
  if (!same_run) {
    from_ = mark;
  } else if (mark.sequence > last_->sequence + 1) {
    frames_.missing += mark.sequence - last_->sequence - 1;
  }
  last_ = mark;
}

void WatchStatistics::add_delay(double seconds) noexcept {
  window_delays_.add(seconds);
  all_delays_.add(seconds);
}

WatchStatistics::Window WatchStatistics::take_window(std::uint32_t tick_hz) {
  Window window;
  window.frames = window_frames_;
  if (from_ && last_->sequence > from_->sequence && last_->tick > from_->tick) {
    window.rate_hz = static_cast<double>(last_->sequence - from_->sequence) * tick_hz /
                     static_cast<double>(last_->tick - from_->tick);
  }
  window.delay = figures_of(window_delays_);
  from_ = last_;
  window_frames_ = 0;
  window_delays_ = LatencyHistogram();
  return window;
}

DelayFigures WatchStatistics::all_delays() const { return figures_of(all_delays_); }

WatchEvent event_of(const sync::TimedEvent& timed) {
  const Event& event = timed.event;
  WatchEvent told;
  told.run = timed.run;
  told.when = timed.when;
  const std::string run = "run " + std::to_string(timed.run) + " ";
  const std::string frame = "frame " + std::to_string(event.sequence);
  switch (event.kind) {
    case Event::Kind::Booted:
      told.kind = "booted";
      told.text = "the board has started, by " + sync::reset_text(event.detail);
      told.run.reset();
      return told;
    case Event::Kind::Started:
      told.kind = "started";
      told.text = run + "has started";
      return told;
    case Event::Kind::Stopped:
      told.kind = "stopped";
      told.text = run + stopped_event_text(event);
      break;
    case Event::Kind::Applied:
      told.kind = "applied";
      told.text = run + "has new settings from " + frame + " on";
      break;
    case Event::Kind::Locked:
      told.kind = "locked";
      told.text = "the supply of the lights is too high, " + volts(event.detail) + ": strobes are locked out";
      break;
    case Event::Kind::Rearmed:
      told.kind = "rearmed";
      told.text = "the supply of the lights is back at " + volts(event.detail) + ": strobes go on";
      break;
    case Event::Kind::Unknown:
      told.kind = "unknown";
      told.text = "something that this program does not know: it is older than the board's firmware";
      return told;
  }
  told.frame = event.sequence;
  return told;
}

void watch(sync::BoardLink& link, WatchSink& sink, const WatchOptions& options,
           const std::atomic<bool>& stop) {
  Watch(link, sink).run(options, stop);
}

}  // namespace glint::apps
