// SPDX-License-Identifier: MIT
// Input reports: numbered, kept for a while, handed to USB one by one.
#pragma once

#include "firmware/protocol/sync_report.h"

namespace glint::board {

/// A ring of the last reports. The oldest that wait are given up when too many do (nobody reads), so that who
/// begins to read gets fresh ones; FETCH still has them.
class ReportLog {
 public:
  static constexpr uint32_t kHeld = 1024;
  static constexpr uint32_t kMostWaiting = 32;

  explicit ReportLog(uint32_t epoch) : epoch_(epoch) {}

  /// A new report; what is not set here (kind, tick, ...) is the caller's to fill in, at once.
  glint_sync_input& append(uint8_t kind, uint16_t run);
  /// The newest report, if it holds triggers of this run, has room and still waits; else null.
  glint_sync_input* open_triggers(uint16_t run);
  /// The next report to send, or null.
  const glint_sync_input* take();
  /// A report already sent or given up; null if it is older than what is held, or still waits.
  const glint_sync_input* find(uint32_t report_no) const;

  uint32_t epoch() const { return epoch_; }
  uint32_t next_no() const { return next_no_; }
  uint32_t oldest_no() const { return next_no_ > kHeld ? next_no_ - kHeld : 0; }
  uint32_t unsent() const { return unsent_; }

 private:
  glint_sync_input ring_[kHeld]{};
  uint32_t epoch_;
  uint32_t next_no_ = 0;
  uint32_t next_to_send_ = 0;
  uint32_t unsent_ = 0;
};

}  // namespace glint::board
