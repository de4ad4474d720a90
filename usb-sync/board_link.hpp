// SPDX-License-Identifier: MIT
// A board that may come and go, as one ordered stream of what it says, in host time.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

#include "usb-sync/clock_model.hpp"
#include "usb-sync/report_stream.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint::sync {

/// The time that next() was given is over.
struct NothingYet {};

/// A frame has begun.
struct TimedTrigger {
  Trigger trigger;
  std::uint64_t sequence = 0;  ///< as trigger.sequence, but does not wrap
  std::uint32_t epoch = 0;
  std::uint16_t run = 0;
  std::uint16_t supply_mv = 0;
  HostInterval begin;  ///< of the frame: `tick` on the host's clock
};

/// Something else happened on the board.
struct TimedEvent {
  Event event;
  std::uint32_t epoch = 0;
  std::uint16_t run = 0;
  std::uint16_t supply_mv = 0;
  std::uint8_t flags = 0;  ///< glint_sync_flags
  HostInterval when;
};

/// The board does not answer; next() keeps looking for it.
struct LinkGone {};

/// It is here again.
struct LinkBack {
  bool was_reset = false;  ///< a new epoch: no run, settings as at power-up
};

/// So many reports were missed for good before what comes next; triggers among them show as a gap in
/// sequence.
struct ReportsLost {
  std::uint64_t count = 0;
};

using LinkUpdate = std::variant<NothingYet, TimedTrigger, TimedEvent, LinkGone, LinkBack, ReportsLost>;

struct LinkOptions {
  std::chrono::milliseconds time_query_period{50};  ///< what the clock model is fed with
  std::chrono::milliseconds status_period{1000};  ///< finds losses at the end of a run; keeps the board alive
  std::chrono::milliseconds reopen_period{200};   ///< how often a board that is gone is looked for
  ClockOptions clock;
};

struct LinkCounters {
  std::uint64_t reports = 0;  ///< received by themselves, leftovers included
  std::uint64_t flawed = 0;   ///< received and refused
  std::uint64_t fetched = 0;  ///< missing, and got back
  std::uint64_t lost = 0;     ///< missing for good
  std::uint64_t stale = 0;    ///< dropped: of an earlier epoch, or known already
  std::uint64_t gone = 0;     ///< how often the board went
  std::uint64_t resets = 0;   ///< how often it came back with a new epoch
};

/// Keeps the connection to one board. Used by one thread, which calls next() again and again, or now and then
/// until NothingYet:
///
///   BoardLink link;
///   BoardPlan plan{.period = Seconds(1.0 / 90.0)};
///   plan.outputs[0] = {.enabled = true, .width = 1ms};                    // a camera
///   plan.outputs[4] = {.enabled = true, .delay = 788us, .width = 137us};  // its light
///   link.board()->start(plan);
///   while (running) {
///     const LinkUpdate update = link.next(100ms);
///     if (const auto* trigger = std::get_if<TimedTrigger>(&update)) use(trigger->sequence,
///     trigger->begin.time);
///   }
///   if (SyncBoard* board = link.board()) board->stop();
///
/// A board that goes away is looked for by its serial number and taken up again; reports that were missed
/// meanwhile are fetched as far as the board remembers them.
class BoardLink {
 public:
  /// Opens the board; throws as SyncBoard::open().
  explicit BoardLink(std::string_view serial = {}, const LinkOptions& options = {},
                     HidBus& bus = machine_hid_bus());

  /// What comes next, or NothingYet after `longest`. Control transfers come on top of that: some
  /// milliseconds; with a board that hangs, as long as it takes its watchdog to reset it.
  LinkUpdate next(std::chrono::milliseconds longest) noexcept;

  /// To talk to the board between two calls of next(); nullptr while it is gone. After an exception go on
  /// with next(), which finds out.
  SyncBoard* board() noexcept { return board_ ? &*board_ : nullptr; }

  /// Of the board that was opened last.
  const Info& info() const noexcept { return info_; }
  /// Not older than status_period while the board is there.
  const Status& last_status() const noexcept { return status_; }
  /// Of the last report that came by itself: arrival less end of what it tells, on the model's clock.
  Seconds last_report_delay() const noexcept { return last_delay_; }
  const ClockModel& clock() const noexcept { return clock_; }
  LinkCounters counters() const noexcept;
  /// Why the board could not be opened again, "" if it was just not there.
  const std::string& reopen_trouble() const noexcept { return reopen_trouble_; }

 private:
  void serve(HostTime now, HostTime deadline) noexcept;
  bool take_up() noexcept;
  void try_reopen() noexcept;
  void lose_board() noexcept;
  bool ask_time() noexcept;
  bool check_status() noexcept;
  void fetch_missing() noexcept;
  void receive(std::chrono::milliseconds longest) noexcept;
  std::optional<LinkUpdate> pending() noexcept;
  std::optional<LinkUpdate> hand_out() noexcept;
  HostInterval host_time(std::uint64_t tick) const noexcept;

  LinkOptions options_;
  HidBus* bus_;
  std::string serial_;
  std::optional<SyncBoard> board_;
  Info info_;
  Status status_;
  ReportStream stream_;
  ClockModel clock_;
  HostTime next_query_, next_status_, next_reopen_;
  std::uint64_t queries_ = 0;
  std::optional<OrderedReport> current_;  // whose triggers are being handed out
  std::size_t handed_out_ = 0;
  std::optional<LinkUpdate> transition_;  // LinkGone or LinkBack, after what came before it
  Seconds last_delay_{0.0};
  std::uint64_t reports_ = 0, flawed_ = 0, gone_ = 0, resets_ = 0;
  std::string reopen_trouble_;
};

}  // namespace glint::sync
