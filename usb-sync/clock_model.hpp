// SPDX-License-Identifier: MIT
// The board's ticks on the host's clock, with a bound on the error.
#pragma once

#include <cstdint>
#include <optional>

#include "usb-sync/envelope.hpp"
#include "usb-sync/feasible_lines.hpp"
#include "usb-sync/host_time.hpp"

namespace glint::sync {

/// One question for the board's counter: the tick was read after `asked` and before `answered`.
struct TimeAnswer {
  HostTime asked, answered;
  std::uint64_t tick = 0;
  std::uint32_t epoch = 0;
};

/// A moment, and how far the truth can be from it.
struct HostInterval {
  HostTime time;
  Seconds half_width{0.0};
};

struct ClockOptions {
  /// Rates of both clocks together, at worst: crystals, and a host clock that is being slewed.
  double max_rate_error = 1e-3;
  /// How quickly the ratio of the rates changes, at worst, per second: crystals that warm up.
  double max_rate_change_per_s = 2e-7;
  /// What the wire takes at least. A full-speed SETUP packet lasts 11 us before the board can see it, and a
  /// report of 56 bytes 40 us after its tick. 0 for boards that are not on a wire.
  Seconds least_request{11e-6};
  Seconds least_answer{40e-6};
};

/// Everything the host learns of the board's counter is an inequality. A time query was answered after it was
/// asked; a report arrives after what it tells. Each excludes half of all straight lines from tick to host
/// time; the lines that are left are a convex polygon in the plane of offset and rate. Older inequalities
/// count less, by as much as the rates may have changed since; which of them matter, two convex hulls tell.
/// (Set membership: Schweppe 1968. Convex hulls of delays: Zhang, Liu and Xia 2002.) So polling, stalls and
/// lopsided round trips widen the bound at worst; they cannot bend the estimate out of it.
///
/// Constant memory, no allocation; some microseconds twenty times a second, else well below one.
class ClockModel {
 public:
  /// `tick_hz` is Info::tick_hz.
  explicit ClockModel(std::uint32_t tick_hz, const ClockOptions& options = {}) noexcept;

  /// A time query. One of another epoch makes the model begin anew.
  void add(const TimeAnswer& answer) noexcept;
  /// A report that was sent after `tick` was here at `arrival`.
  void add_arrival(std::uint64_t tick, HostTime arrival) noexcept;

  /// When that tick was, or will be. The truth is within half_width, as long as the options hold. Nothing
  /// before the first time query.
  std::optional<HostInterval> at(std::uint64_t tick) const noexcept;

  /// Host seconds per second of the board, less 1: 30e-6 is a board that is 30 ppm slow.
  double rate_error() const noexcept;

  /// How often nothing was left: the clocks did not keep to the options (a host clock that is slewed hard, a
  /// suspended machine), and the model began anew with what it was told last.
  std::uint64_t contradictions() const noexcept { return contradictions_; }

 private:
  /// Delays behind the inequalities of one side, of the last seconds.
  struct Delays {
    double count = 0.0, sum_s = 0.0;
    void add(double delay_s) noexcept;
    /// How far the nearest of them may be from the truth, in an unknown unit.
    double slack() const noexcept;
  };

  void restart(const TimeAnswer& answer) noexcept;
  bool observe(Envelope& envelope, std::uint64_t tick, HostTime bound) noexcept;
  bool narrow(const Envelope& envelope, Envelope::Point point) noexcept;
  bool look_from(double x) noexcept;
  double x_of(std::uint64_t tick) const noexcept;
  double estimate(double x) const noexcept;

  ClockOptions options_;
  double tick_s_;
  bool known_ = false;
  TimeAnswer last_;  // where to begin anew
  // x: board time since origin_tick_, y: host time since origin_time_, less x; seconds.
  std::uint64_t origin_tick_ = 0;
  HostTime origin_time_;
  Envelope upper_, lower_;              // arrivals and answers, requests
  Delays after_, before_;               // of the same
  double view_x_ = 0.0, view_y_ = 0.0;  // where lines_ is looked at from
  FeasibleLines lines_;                 // tangents there
  std::uint64_t contradictions_ = 0;
};

}  // namespace glint::sync
