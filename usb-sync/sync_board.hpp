// SPDX-License-Identifier: MIT
// One open sync board: what to ask of it and to tell it.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "usb-sync/board_plan.hpp"
#include "usb-sync/board_state.hpp"
#include "usb-sync/clock_model.hpp"
#include "usb-sync/error.hpp"
#include "usb-sync/hid_port.hpp"
#include "usb-sync/input_report.hpp"

namespace glint::sync {

/// The boards that are plugged in.
std::vector<FoundBoard> find_boards(HidBus& bus = machine_hid_bus());

/// What a wait for a report gave.
struct ReadResult {
  enum class Kind : std::uint8_t {
    Nothing,  ///< the time is over
    Report,
    Flawed,  ///< a report that says nothing; `flaw` tells why
    Gone,    ///< unplugged or reset: open the board anew
  };
  Kind kind = Kind::Nothing;
  HostTime arrival;  ///< when it was here
  Flaw flaw = Flaw::None;
  InputReport report;
};

/// Owns the open device; is used by one thread. Commands throw Refused if the board says no, and BoardGone if
/// it says nothing. Settings live in the board: they stay when this object goes, and so does a run, unless
/// the plan has a keep-alive time.
class SyncBoard {
 public:
  /// The board with that serial number, or the only one. Throws NoBoard; Error if there are several (names
  /// them), it may not be opened (names the udev rule), or speaks another major protocol (names the
  /// firmware).
  static SyncBoard open(std::string_view serial = {}, HidBus& bus = machine_hid_bus());

  explicit SyncBoard(std::unique_ptr<HidPort> port);
  SyncBoard(SyncBoard&&) noexcept = default;
  SyncBoard& operator=(SyncBoard&&) noexcept = default;

  /// As it was when the board was opened.
  const Info& info() const noexcept { return info_; }
  Info read_info();
  Status status();

  Limits limits();
  /// Returns what is now in force. The board refuses what is above the firmware's caps.
  Limits set_limits(const Limits& wanted);

  /// What is staged: the next start() or apply() takes it.
  BoardPlan staged();
  /// Stages the plan; nothing happens yet. Returns it on the board's grid of ticks.
  BoardPlan stage(const BoardPlan& plan);
  /// Begins a run with what is staged.
  void start();
  /// What is staged takes effect in the run, on a frame that is not planned yet: see
  /// Status::applied_sequence.
  void apply();
  BoardPlan start(const BoardPlan& plan);
  BoardPlan apply(const BoardPlan& plan);
  /// After the frame that is under way.
  void stop();
  /// As stop(), and waits until the last pulses are over: three of the longest periods, 35 s, at most.
  /// Returns the status then. Throws Error if it takes longer.
  Status end_run();
  /// The fault that stands.
  void clear_fault();

  /// Sends pulses from an output that is wired to sync in, and waits until they are measured. Not while
  /// running. Throws Error if that takes longer than two seconds.
  SelfTestResult self_test(std::size_t output);
  SelfTestResult self_test_result();

  /// Both end the connection: this object is good for nothing afterwards.
  void reset();
  void enter_bootloader();

  // For the loop: values, noexcept.

  /// Waits for a report, at most so long.
  ReadResult read(std::chrono::milliseconds longest) noexcept;
  /// When the board's counter was where. Nothing if the board is gone.
  std::optional<TimeAnswer> ask_time() noexcept;
  /// A report of this epoch once more, or NotHeld. Nothing if the board is gone or talks nonsense.
  std::optional<InputReport> fetch(std::uint32_t report_no) noexcept;
  /// As status(), but nothing if the board is gone.
  std::optional<Status> try_status() noexcept;

 private:
  using Report = std::array<std::uint8_t, GLINT_SYNC_REPORT_BYTES>;
  std::optional<Report> try_get(std::uint8_t id) noexcept;
  Report get(std::uint8_t id, const char* what);
  template <class Wire>
  void set(const Wire& report, const char* what);
  void command(std::uint8_t code, std::uint32_t argument, const char* what);
  void command_and_leave(std::uint8_t code, std::uint32_t argument, const char* what);
  [[noreturn]] void throw_why(const char* what);
  [[noreturn]] void throw_gone(const char* what) const;

  std::unique_ptr<HidPort> port_;
  Info info_;
};

}  // namespace glint::sync
