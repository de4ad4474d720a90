// SPDX-License-Identifier: MIT
// Reports in the order in which the board wrote them, none twice, and what is lost counted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>

#include "usb-sync/input_report.hpp"

namespace glint::sync {

/// The next report in order.
struct OrderedReport {
  InputReport report;
  std::uint64_t lost_before = 0;     ///< reports between the one before and this, for good
  std::uint64_t first_sequence = 0;  ///< Triggers: number of the first frame, which does not wrap
};

/// Reports arrive with gaps (the kernel keeps 63 unread ones and drops the newest), and after a reopen with
/// leftovers of an earlier epoch or run. Numbers decide: what is older than the next one is dropped; what is
/// newer waits while the missing ones are fetched from the board, which remembers some. No input or output of
/// its own; memory is bounded and nothing is allocated after construction.
class ReportStream {
 public:
  /// So many reports, from the next on, can wait for a missing one; later ones are fetched when it is their
  /// turn.
  static constexpr std::size_t kWindow = 256;

  /// The board was opened, and says that it is in `epoch` and will write report `next_report_no` next. In the
  /// epoch that was known before, nothing changes: what was missed is found by what comes. A new epoch is
  /// wanted from its first report. The very first time, only what comes from now on is wanted.
  void opened(std::uint32_t epoch, std::uint32_t next_report_no) noexcept;

  /// A report that the board sent by itself.
  void add(const InputReport& report) noexcept;

  /// STATUS says that all reports before this one are written: shows the loss of the newest ones.
  void written(std::uint32_t epoch, std::uint32_t next_report_no) noexcept;

  /// The number of the report to fetch now, if one is missing and nothing is ready in next().
  std::optional<std::uint32_t> wanted() const noexcept;
  /// The answer for wanted().
  void add_fetched(const InputReport& answer) noexcept;
  /// wanted() could not be fetched: it counts as lost.
  void give_up() noexcept;

  /// Nothing more can be fetched: what is missing before a report that waits is lost. False if none waits.
  bool skip_missing() noexcept;

  /// The next report in order, if it is there.
  std::optional<OrderedReport> next() noexcept;

  /// A report of an epoch that is not the board's: ask INFO whether the board was reset. Cleared by opened().
  bool strange_epoch() const noexcept { return strange_epoch_; }

  std::uint32_t epoch() const noexcept { return epoch_; }
  std::uint64_t delivered() const noexcept { return delivered_; }
  std::uint64_t fetched() const noexcept { return fetched_; }  ///< missing ones that were got back
  std::uint64_t lost() const noexcept { return lost_; }        ///< missing ones that stay so
  std::uint64_t stale() const noexcept { return stale_; }      ///< dropped: of another epoch, or come before

 private:
  bool store(const InputReport& report) noexcept;
  std::uint32_t missing() const noexcept;
  void lose(std::uint32_t count) noexcept;
  std::uint64_t unwrapped(const InputReport& report, std::uint32_t sequence) noexcept;
  bool waits(std::uint32_t report_no) const noexcept;

  bool known_ = false, strange_epoch_ = false;
  std::uint32_t epoch_ = 0;
  std::uint32_t next_ = 0;  // the report to deliver next
  std::uint32_t end_ = 0;   // one past the newest that is known to be written; next_ or later
  std::array<InputReport, kWindow> waiting_{};  // report n at n % kWindow
  std::array<bool, kWindow> taken_{};
  std::uint64_t lost_before_next_ = 0;
  std::uint16_t run_ = 0;
  std::uint64_t last_sequence_ = 0;
  std::uint64_t delivered_ = 0, fetched_ = 0, lost_ = 0, stale_ = 0;
};

}  // namespace glint::sync
