// SPDX-License-Identifier: MIT
// When each pulse of the rig was fired: fitted to the cameras' stamps, or told by the sync board.
#pragma once

#include <array>
#include <cstdint>

namespace glint {

/// Pulse number to time and back. Times are seconds since an origin of the caller's choice. Without a board
/// the grid is a straight line (phase and period) in a Kalman filter with a slowly wandering period; with a
/// board it is the table of the pulses that the board reported, with a straight line between and beyond them.
class PulseGrid {
 public:
  explicit PulseGrid(double nominal_period_s) noexcept;

  /// Fitted grid: pulse `pulse` was at `time_s`, known with that variance; the period starts at its nominal
  /// value.
  void start(std::int64_t pulse, double time_s, double variance_s2) noexcept;
  /// Fitted grid: a measurement of one pulse's time. One that is far off is taken for less than it says.
  void observe(std::int64_t pulse, double time_s, double variance_s2) noexcept;
  /// Fitted grid: all pulses were that much later.
  void move(double by_s) noexcept { time_s_ += by_s; }

  /// The board reports a pulse. False if it does not follow the one before in number and time: the first
  /// ever, or the board was reset; what was known is forgotten then. One that is known already changes
  /// nothing.
  bool add_reported(std::int64_t pulse, double time_s, bool lights_on) noexcept;
  bool reported() const noexcept { return reported_; }

  double time_s(std::int64_t pulse) const noexcept;
  std::int64_t nearest(double time_s) const noexcept;
  /// Of time_s(pulse); 0 with a board.
  double variance_s2(std::int64_t pulse) const noexcept;
  double period_s() const noexcept { return period_s_; }
  /// False for a pulse too far beyond the last one that the board reported: it may have paused.
  bool credible(std::int64_t pulse) const noexcept;
  /// The board says that the light was off.
  bool dark(std::int64_t pulse) const noexcept;

 private:
  struct Report {
    std::int64_t pulse = -1;
    double time_s = 0.0;
    bool lights_on = true;
  };
  static constexpr std::size_t kReports = 64;
  const Report* find(std::int64_t pulse) const noexcept;
  const Report& report_near(std::int64_t pulse) const noexcept;

  double nominal_period_s_;
  // The line: pulse_ was at time_s_; covariance of (time, period).
  std::int64_t pulse_ = 0;
  double time_s_ = 0.0, period_s_;
  double time_time_ = 0.0, time_period_ = 0.0, period_period_ = 0.0;
  // The board's table, by pulse modulo its size.
  bool reported_ = false, period_measured_ = false;
  Report last_;
  std::array<Report, kReports> reports_{};
};

}  // namespace glint
