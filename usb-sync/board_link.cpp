// SPDX-License-Identifier: MIT
#include "usb-sync/board_link.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

namespace glint::sync {
namespace {

std::chrono::milliseconds rounded_up(HostClock::duration time) noexcept {
  return std::max(std::chrono::ceil<std::chrono::milliseconds>(time), std::chrono::milliseconds(0));
}

}  // namespace

BoardLink::BoardLink(std::string_view serial, const LinkOptions& options, HidBus& bus)
    : options_(options), bus_(&bus), board_(SyncBoard::open(serial, bus)), clock_(1, options.clock) {
  if (!take_up()) throw BoardGone("the sync board does not answer any more: plug it in again");
  transition_.reset();
  serial_ = info_.serial;
}

LinkUpdate BoardLink::next(std::chrono::milliseconds longest) noexcept {
  const HostTime deadline = HostClock::now() + longest;
  while (true) {
    if (auto update = pending()) return *update;
    const HostTime now = HostClock::now();
    if (board_) {
      serve(now, deadline);
    } else if (now >= next_reopen_) {
      try_reopen();
    } else {
      std::this_thread::sleep_until(std::min(deadline, next_reopen_));
    }
    if (HostClock::now() >= deadline) {
      if (board_) receive(std::chrono::milliseconds(0));  // so that calls with no time at all keep up, too
      const auto update = pending();
      return update ? *update : NothingYet{};
    }
  }
}

LinkCounters BoardLink::counters() const noexcept {
  return {.reports = reports_,
          .flawed = flawed_,
          .fetched = stream_.fetched(),
          .lost = stream_.lost(),
          .stale = stream_.stale(),
          .gone = gone_,
          .resets = resets_};
}

/// One thing that is due, or a wait for a report.
void BoardLink::serve(HostTime now, HostTime deadline) noexcept {
  if (stream_.strange_epoch()) {
    if (!take_up()) lose_board();
  } else if (now >= next_query_) {
    if (!ask_time()) lose_board();
  } else if (now >= next_status_) {
    if (!check_status()) lose_board();
  } else if (stream_.wanted()) {
    receive(std::chrono::milliseconds(0));  // the kernel's queue must not overflow meanwhile
    if (board_) fetch_missing();
  } else {
    receive(rounded_up(std::min({deadline, next_query_, next_status_}) - now));
  }
}

/// Who the board is, where its numbers and its clock are. False if it does not answer.
bool BoardLink::take_up() noexcept {
  Info info;
  Status status;
  try {
    info = board_->read_info();
    status = board_->status();
  } catch (const std::exception& error) {
    reopen_trouble_ = error.what();
    return false;
  }
  if (info.tick_hz != info_.tick_hz) clock_ = ClockModel(info.tick_hz, options_.clock);
  constexpr int kFirstQueries = 8;  // the clock is known before the first report
  for (int i = 0; i < kFirstQueries; ++i) {
    if (!ask_time()) return false;
  }
  // Only now that all has been answered: who is told of a reset twice, or not at all, would start it wrongly.
  const bool first = info_.tick_hz == 0, was_reset = !first && info.epoch != info_.epoch;
  info_ = info;
  status_ = status;
  stream_.opened(info.epoch, status.next_report_no);
  if (was_reset) ++resets_;
  transition_ = LinkBack{was_reset};
  next_status_ = HostClock::now() + options_.status_period;
  reopen_trouble_.clear();
  return true;
}

void BoardLink::try_reopen() noexcept {
  next_reopen_ = HostClock::now() + options_.reopen_period;
  try {
    board_ = SyncBoard::open(serial_, *bus_);
  } catch (const NoBoard&) {
    reopen_trouble_.clear();
    return;
  } catch (const std::exception& error) {  // after a replug, udev may not have given permission yet
    reopen_trouble_ = error.what();
    return;
  }
  if (!take_up()) board_.reset();
}

void BoardLink::lose_board() noexcept {
  board_.reset();
  ++gone_;
  transition_.emplace(LinkGone{});
  next_reopen_ = HostClock::now();
}

/// The queries must not keep step with the bus, whose grid of milliseconds would delay all of them alike.
bool BoardLink::ask_time() noexcept {
  const auto answer = board_->ask_time();
  if (!answer) return false;
  clock_.add(*answer);
  ++queries_;
  constexpr double kGoldenRatio = 0.6180339887498949;
  double whole = 0.0;
  const double spread = 0.75 + 0.5 * std::modf(kGoldenRatio * static_cast<double>(queries_), &whole);
  next_query_ = HostClock::now() +
                std::chrono::duration_cast<HostClock::duration>(Seconds(options_.time_query_period) * spread);
  return true;
}

bool BoardLink::check_status() noexcept {
  const auto status = board_->try_status();
  if (!status) return false;
  // What was written a period ago has arrived by now, or is lost.
  stream_.written(status_.epoch, status_.next_report_no);
  status_ = *status;
  next_status_ = HostClock::now() + options_.status_period;
  return status_.epoch == info_.epoch || take_up();
}

void BoardLink::fetch_missing() noexcept {
  const auto number = stream_.wanted();
  if (!number) return;
  if (const auto answer = board_->fetch(*number)) {
    stream_.add_fetched(*answer);
  } else if (board_->try_status()) {
    stream_.give_up();
  } else {
    lose_board();
  }
}

void BoardLink::receive(std::chrono::milliseconds longest) noexcept {
  const ReadResult result = board_->read(longest);
  switch (result.kind) {
    case ReadResult::Kind::Nothing:
      break;
    case ReadResult::Kind::Gone:
      lose_board();
      break;
    case ReadResult::Kind::Flawed:
      ++flawed_;
      break;
    case ReadResult::Kind::Report:
      ++reports_;
      stream_.add(result.report);
      if (const auto tick = result.report.sent_after(); tick && result.report.epoch == info_.epoch) {
        clock_.add_arrival(*tick, result.arrival);
        last_delay_ = result.arrival - host_time(*tick).time;
      }
      break;
  }
}

/// What is ready to be handed out, in order; the board's coming and going behind what it said before.
std::optional<LinkUpdate> BoardLink::pending() noexcept {
  while (true) {
    if (current_) {
      if (current_->lost_before > 0) {
        const ReportsLost lost{current_->lost_before};
        current_->lost_before = 0;
        return lost;
      }
      if (auto update = hand_out()) return update;
      current_.reset();
    }
    current_ = stream_.next();
    handed_out_ = 0;
    if (current_ || (!board_ && stream_.skip_missing())) continue;
    if (!transition_) return std::nullopt;
    const LinkUpdate update = *transition_;
    transition_.reset();
    return update;
  }
}

/// The next thing that the report at hand tells.
std::optional<LinkUpdate> BoardLink::hand_out() noexcept {
  const InputReport& report = current_->report;
  if (const auto* event = std::get_if<Event>(&report.content)) {
    if (handed_out_++ > 0) return std::nullopt;
    return TimedEvent{*event,           report.epoch, report.run,
                      report.supply_mv, report.flags, host_time(event->tick)};
  }
  const auto* triggers = std::get_if<Triggers>(&report.content);
  if (triggers == nullptr || handed_out_ == triggers->count) return std::nullopt;
  const std::size_t i = handed_out_++;
  const Trigger& trigger = triggers->list[i];
  return TimedTrigger{trigger,          current_->first_sequence + i, report.epoch, report.run,
                      report.supply_mv, host_time(trigger.tick)};
}

/// The clock is known: take_up() asks for it before anything is received.
HostInterval BoardLink::host_time(std::uint64_t tick) const noexcept {
  return clock_.at(tick).value_or(HostInterval{});
}

}  // namespace glint::sync
