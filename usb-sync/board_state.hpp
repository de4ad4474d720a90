// SPDX-License-Identifier: MIT
// What the board says about itself when asked: who it is, how it is, what it allows, how its self-test went.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "firmware/protocol/sync_report.h"
#include "usb-sync/host_time.hpp"

namespace glint::sync {

/// Who the board is; does not change while it is plugged in, but for the epoch.
struct Info {
  int protocol_major = 0, protocol_minor = 0;
  int outputs = 0, triggers = 0;
  bool strobes_active_low = false;     ///< as the jumper on the board says
  std::uint32_t firmware_version = 0;  ///< major << 16 | minor << 8 | patch
  std::uint32_t tick_hz = 0;           ///< never 0
  std::uint32_t held_reports = 0;      ///< how many input reports can be fetched again
  std::uint32_t epoch = 0;             ///< another number after each reset
  std::string serial;                  ///< 16 hexadecimal digits, as in the USB descriptor
  std::string build;                   ///< name of the commit

  /// "1.2.3".
  std::string firmware_text() const;
};

enum class RunState : std::uint8_t {
  Idle = GLINT_SYNC_IDLE,
  Running = GLINT_SYNC_RUNNING,
  Waiting = GLINT_SYNC_WAITING,  ///< for an edge at sync in
  Testing = GLINT_SYNC_TESTING,
};

/// How the board is, at one moment.
struct Status {
  RunState state = RunState::Idle;
  bool supply_locked = false;   ///< the supply is too high: strobes are held off
  bool after_watchdog = false;  ///< the watchdog ended the epoch before this one
  std::uint32_t epoch = 0;
  std::uint32_t next_report_no = 0;
  int run = 0;  ///< counted from 1 within the epoch; 0 before the first
  double supply_v = 0.0;
  std::uint64_t now_tick = 0;
  std::uint32_t sequence = 0;          ///< frames of this run that have begun
  std::uint32_t applied_sequence = 0;  ///< first frame of the plan in force
  std::uint32_t unsent = 0;            ///< reports of this epoch that the host did not take in time
  std::uint32_t ignored_edges = 0;     ///< at sync in, sooner than the period allows; this run
  std::uint32_t held_strobes = 0;      ///< pulses left out, because too soon after the last; this run
  int lockouts = 0;                    ///< in this epoch
  std::uint8_t fault = 0;              ///< glint_sync_fault; 0: none
  std::uint8_t stop_reason = 0;        ///< glint_sync_stop of the last run
  std::uint8_t reset_reason = 0;       ///< glint_sync_reset
  std::uint8_t refusal = 0;            ///< glint_sync_refusal of the last setting; 0: accepted
  std::optional<int> refusal_output;
  std::uint32_t refusal_limit = 0;  ///< in the unit of the setting that broke it
};

/// What strobes and frames are held to. The first four can be lowered, and raised again up to the firmware's
/// own caps; the others are the firmware's alone and are ignored when set.
struct Limits {
  double lockout_v = 0.0;        ///< strobes go off above
  double rearm_v = 0.0;          ///< and come back below; at least 0.1 V lower
  double strobe_max_duty = 0.0;  ///< share of time that a strobe may be on, from each rise to the next: 0.025
  Seconds strobe_max_width{0.0};
  Seconds min_period{0.0}, max_period{0.0};
  Seconds min_width{0.0};
  Seconds min_gap{0.0};  ///< from the end of an output's pulse to its next
};

struct SelfTestResult {
  enum class State : std::uint8_t {
    None = GLINT_SYNC_SELFTEST_NONE,
    Running = GLINT_SYNC_SELFTEST_RUNNING,
    Done = GLINT_SYNC_SELFTEST_DONE,
  };
  State state = State::None;
  int output = 0;
  std::uint32_t sent = 0;
  std::uint32_t seen = 0;  ///< pulses measured at sync in; 0: no wire from the output to sync in
  Seconds resolution{0.0};
  Seconds width{0.0}, least_width{0.0}, most_width{0.0};     ///< as sent, as measured
  Seconds period{0.0}, least_period{0.0}, most_period{0.0};  ///< as sent, as measured

  /// Every pulse was seen once, and all widths and periods are right to within the resolution (a period is
  /// made of two measurements).
  bool passed() const noexcept;
};

/// The answers of the board, checked: nothing if the length, report id or protocol is another one, or a value
/// has no meaning. `bytes` is a whole report, its id included.
std::optional<Info> parse_info(std::span<const std::uint8_t> bytes);
std::optional<Status> parse_status(std::span<const std::uint8_t> bytes) noexcept;
std::optional<Limits> parse_limits(std::span<const std::uint8_t> bytes, std::uint32_t tick_hz) noexcept;
std::optional<SelfTestResult> parse_selftest(std::span<const std::uint8_t> bytes,
                                             std::uint32_t tick_hz) noexcept;

/// Throws Error if a value cannot be said in the report.
glint_sync_limits to_report(const Limits& limits, std::uint32_t tick_hz);

}  // namespace glint::sync
