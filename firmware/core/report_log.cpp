// SPDX-License-Identifier: MIT
#include "firmware/core/report_log.hpp"

namespace glint::board {

glint_sync_input& ReportLog::append(uint8_t kind, uint16_t run) {
  if (next_no_ - next_to_send_ == kMostWaiting) {
    ++next_to_send_;
    ++unsent_;
  }
  glint_sync_input& report = ring_[next_no_ % kHeld];
  report = {};
  report.report_id = GLINT_SYNC_INPUT;
  report.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
  report.kind = kind;
  report.epoch = epoch_;
  report.report_no = next_no_++;
  report.run = run;
  return report;
}

glint_sync_input* ReportLog::open_triggers(uint16_t run) {
  if (next_to_send_ == next_no_) return nullptr;
  glint_sync_input& newest = ring_[(next_no_ - 1) % kHeld];
  const bool room = newest.kind == GLINT_SYNC_KIND_TRIGGERS && newest.count < GLINT_SYNC_TRIGGERS_PER_REPORT;
  return room && newest.run == run ? &newest : nullptr;
}

const glint_sync_input* ReportLog::take() {
  if (next_to_send_ == next_no_) return nullptr;
  glint_sync_input& report = ring_[next_to_send_++ % kHeld];
  report.queued = static_cast<uint8_t>(next_no_ - next_to_send_);
  report.unsent = static_cast<uint16_t>(unsent_ < 0xffff ? unsent_ : 0xffff);
  return &report;
}

const glint_sync_input* ReportLog::find(uint32_t report_no) const {
  const bool sent = report_no < next_to_send_;
  return sent && report_no >= oldest_no() ? &ring_[report_no % kHeld] : nullptr;
}

}  // namespace glint::board
