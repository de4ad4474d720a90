// SPDX-License-Identifier: MIT
// The board's behaviour, all but the chip: runs, reports, limits, faults.
#pragma once

#include "firmware/core/frame_planner.hpp"
#include "firmware/core/pulse_hardware.hpp"
#include "firmware/core/report_log.hpp"
#include "firmware/core/supply_monitor.hpp"

namespace glint::board {

/// What only the chip knows when it starts.
struct Identity {
  uint8_t serial[8];
  uint32_t epoch;
  uint8_t reset_reason;  ///< glint_sync_reset
  bool strobes_active_low;
  uint32_t firmware_version;
  const char* build;  ///< name of the commit
};

/// What the caller has to do after a SET.
enum class Request : uint8_t { None, Reset, Bootloader };

/// Driven by events; every call takes the time, which never goes back. Calls must not interrupt each other.
/// When next_due() has come, on_timer() must be called: not more than kMostTimerDelay late.
class SyncDevice {
 public:
  static constexpr uint32_t kMostTimerDelay = ticks_of_us(40);
  static constexpr uint64_t kNever = ~uint64_t{0};

  SyncDevice(PulseHardware& hardware, const Identity& identity, uint64_t now);

  uint64_t next_due() const;
  void on_timer(uint64_t now);
  /// An edge at sync in that began a frame, at `edge`.
  void on_edge(uint64_t edge);
  void on_supply(uint16_t mv, uint64_t now);
  /// The bus is suspended or was reset.
  void on_bus_lost(uint64_t now);

  /// A SET_REPORT. True: taken; `request` says what else is to be done.
  bool set_report(const uint8_t* bytes, uint32_t size, uint64_t now, Request& request);
  /// A GET_REPORT: fills GLINT_SYNC_REPORT_BYTES; false: there is no such report. `asked` is when the request
  /// arrived.
  bool get_report(uint8_t report_id, uint8_t* bytes, uint64_t asked, uint64_t now);
  /// The next input report to send, or null.
  const glint_sync_input* take_report() { return log_.take(); }

  bool running() const { return state_ != GLINT_SYNC_IDLE; }

 private:
  /// Of the last run, which self-tests leave as it is.
  struct Record {
    uint32_t begun = 0;             // frames that have begun
    uint32_t applied_sequence = 0;  // first frame of the active plan
    uint32_t ignored_edges = 0;
    uint8_t stop_reason = GLINT_SYNC_STOP_COMMAND;
  };
  struct Planned {
    uint64_t tick;
    uint32_t sequence;
    uint8_t outputs, flags;
  };

  Refusal set(const uint8_t* bytes, uint32_t size, uint64_t now, Request& request);
  Refusal set_limits(const glint_sync_limits& wanted);
  Refusal command(const glint_sync_command& command, uint64_t now, Request& request);
  Refusal start(const Plan& plan, uint64_t now);
  Refusal apply();
  Refusal start_self_test(uint32_t output, uint64_t now);
  void begin(const Plan& plan, uint64_t now, int measured);

  void plan_next(uint64_t now);
  void take_applied(uint64_t now);
  void feed(const Frame& frame);
  void arm(uint64_t now);
  void log_trigger(Planned fired);
  void stop_planning(uint8_t reason, uint64_t now);
  void finish();
  void fail(uint8_t fault);
  void collect_self_test();

  glint_sync_input& event(uint8_t kind, uint64_t tick, uint32_t detail);
  uint8_t flags() const;
  glint_sync_status status(uint64_t now) const;
  glint_sync_limits limits() const;
  glint_sync_info info() const;

  PulseHardware& hardware_;
  Identity identity_;
  ReportLog log_;
  FramePlanner planner_;
  SupplyMonitor supply_;

  Plan staged_;
  Plan applied_;  // checked, not in force yet
  Plan active_;
  bool apply_pending_ = false;
  uint8_t state_ = GLINT_SYNC_IDLE;
  uint8_t fault_ = GLINT_SYNC_FAULT_NONE;
  Refusal refusal_;
  uint16_t run_ = 0;
  Record record_, record_before_test_;
  uint32_t planned_ = 0;       // frames of this run planned
  bool planning_ = false;      // further frames are to come
  bool armed_ = false;         // external: the gate is open
  uint64_t arm_at_ = kNever;   // external: when the gate may open again
  Frame frame_{};              // the newest planned
  Planned waiting_[4]{};       // planned, not begun: a ring by sequence
  uint64_t last_logged_ = 0;   // tick of the newest trigger reported
  uint64_t ends_at_ = kNever;  // when the last pulse of a run that stops is over

  bool locked_ = false;
  uint16_t lockouts_ = 0;
  uint64_t last_sample_ = 0;
  uint64_t last_word_ = 0;        // from the host
  uint32_t self_test_width_ = 0;  // of the pulse measured last; 0: none yet
  uint32_t fetch_no_ = 0;
  uint32_t time_queries_ = 0;
  glint_sync_selftest self_test_{};
};

}  // namespace glint::board
