// SPDX-License-Identifier: MIT
#include "usb-sync/report_stream.hpp"

#include <algorithm>

namespace glint::sync {
namespace {

/// Numbers wrap: `one` is ahead of `other` by so many; negative if behind.
std::int32_t ahead(std::uint32_t one, std::uint32_t other) noexcept {
  return static_cast<std::int32_t>(one - other);
}

}  // namespace

void ReportStream::opened(std::uint32_t epoch, std::uint32_t next_report_no) noexcept {
  strange_epoch_ = false;
  if (known_ && epoch == epoch_) return;
  lose(end_ - next_);  // what is still to come of the epoch before will not
  taken_.fill(false);
  run_ = 0;
  epoch_ = epoch;
  next_ = known_ ? 0 : next_report_no;
  end_ = next_report_no;
  known_ = true;
}

void ReportStream::add(const InputReport& report) noexcept {
  if (!known_ || report.epoch != epoch_) {
    strange_epoch_ = known_;
    ++stale_;
    return;
  }
  if (!store(report)) ++stale_;
}

void ReportStream::written(std::uint32_t epoch, std::uint32_t next_report_no) noexcept {
  if (known_ && epoch == epoch_ && ahead(next_report_no, end_) > 0) end_ = next_report_no;
}

std::optional<std::uint32_t> ReportStream::wanted() const noexcept {
  if (ahead(end_, next_) <= 0 || waits(next_)) return std::nullopt;
  return next_;
}

void ReportStream::add_fetched(const InputReport& answer) noexcept {
  if (!wanted()) return;
  if (answer.epoch != epoch_) {
    strange_epoch_ = true;
    give_up();
    return;
  }
  if (const auto* not_held = std::get_if<NotHeld>(&answer.content)) {
    const std::uint32_t gap = missing();
    const std::int32_t forgotten = ahead(not_held->oldest_held, next_);
    if (forgotten > 0) {
      lose(std::min(static_cast<std::uint32_t>(forgotten), gap));
    } else if (next_ + gap == end_) {
      end_ = next_;  // written, but not sent yet: it will come by itself
    } else {
      give_up();  // though later ones were sent
    }
  } else if (answer.report_no == next_) {
    if (store(answer)) ++fetched_;
  } else {
    give_up();
  }
}

void ReportStream::give_up() noexcept {
  if (wanted()) lose(1);
}

bool ReportStream::skip_missing() noexcept {
  const std::uint32_t gap = missing();
  if (gap == 0 || next_ + gap == end_) return false;
  lose(gap);
  return true;
}

std::optional<OrderedReport> ReportStream::next() noexcept {
  if (!waits(next_)) return std::nullopt;
  const std::size_t slot = next_ % kWindow;
  taken_[slot] = false;
  ++next_;
  ++delivered_;
  OrderedReport ordered{waiting_[slot], lost_before_next_, 0};
  lost_before_next_ = 0;
  if (const auto* triggers = std::get_if<Triggers>(&ordered.report.content)) {
    ordered.first_sequence = unwrapped(ordered.report, triggers->list[0].sequence);
    last_sequence_ = ordered.first_sequence;
  }
  return ordered;
}

/// False if it is old or known. One that is too far ahead is only noted: it is fetched when its turn comes.
bool ReportStream::store(const InputReport& report) noexcept {
  const std::int32_t place = ahead(report.report_no, next_);
  if (place < 0 || waits(report.report_no)) return false;
  if (ahead(report.report_no + 1, end_) > 0) end_ = report.report_no + 1;
  if (place < static_cast<std::int32_t>(kWindow)) {
    waiting_[report.report_no % kWindow] = report;
    taken_[report.report_no % kWindow] = true;
  }
  return true;
}

/// From the next report on, up to the first that waits or to the end.
std::uint32_t ReportStream::missing() const noexcept {
  const std::uint32_t behind = end_ - next_;
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(behind, kWindow); ++i) {
    if (waits(next_ + i)) return i;
  }
  return behind;
}

/// The next `count` reports will not come.
void ReportStream::lose(std::uint32_t count) noexcept {
  lost_ += count;
  lost_before_next_ += count;
  next_ += count;
}

bool ReportStream::waits(std::uint32_t report_no) const noexcept {
  const std::size_t slot = report_no % kWindow;
  return taken_[slot] && waiting_[slot].report_no == report_no;
}

std::uint64_t ReportStream::unwrapped(const InputReport& report, std::uint32_t sequence) noexcept {
  if (report.run != run_) {
    run_ = report.run;
    last_sequence_ = sequence;
    return sequence;
  }
  const std::int32_t step = ahead(sequence, static_cast<std::uint32_t>(last_sequence_));
  return last_sequence_ + static_cast<std::uint64_t>(static_cast<std::int64_t>(step));
}

}  // namespace glint::sync
