// SPDX-License-Identifier: MIT
// A Kalman filter on (time of a pulse, period), and the table of reported pulses.
#include "host/assemble/pulse_grid.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace glint {
namespace {

constexpr double kNominalPeriodError = 1e-3;  // crystals are 1e-4 off; drivers round the rates that they tell
constexpr double kPeriodWander = 3e-7;    // per pulse; crystals are steadier, stamps have errors that last
constexpr double kFarOff = 3.0;           // standard deviations
constexpr std::int64_t kPulsesAhead = 8;  // a frame may come before the report of its pulse
constexpr double kMostOftenTheRate = 4.0, kMostInNoTime = 64.0;  // a count that runs faster is of another run
constexpr double kPeriodGain = 0.1;  // of the board's pulses; their times are exact

}  // namespace

PulseGrid::PulseGrid(double nominal_period_s) noexcept
    : nominal_period_s_(nominal_period_s), period_s_(nominal_period_s) {}

void PulseGrid::start(std::int64_t pulse, double time_s, double variance_s2) noexcept {
  pulse_ = pulse;
  time_s_ = time_s;
  period_s_ = nominal_period_s_;
  time_time_ = variance_s2;
  time_period_ = 0.0;
  period_period_ = std::pow(kNominalPeriodError * nominal_period_s_, 2);
}

void PulseGrid::observe(std::int64_t pulse, double time_s, double variance_s2) noexcept {
  if (pulse > pulse_) {  // predict; the period does a random walk
    const auto steps = static_cast<double>(pulse - pulse_);
    const double wander = std::pow(kPeriodWander * nominal_period_s_, 2);
    time_s_ += steps * period_s_;
    time_time_ += steps * (2.0 * time_period_ + steps * (period_period_ + steps * wander / 3.0));
    time_period_ += steps * (period_period_ + steps * wander / 2.0);
    period_period_ += steps * wander;
    pulse_ = pulse;
  }
  const auto back = static_cast<double>(pulse - pulse_);  // measured is time + back * period; back <= 0
  const double to_time = time_time_ + back * time_period_, to_period = time_period_ + back * period_period_;
  const double total = to_time + back * to_period + variance_s2;
  const double bound = kFarOff * std::sqrt(total);
  const double error = std::clamp(time_s - time_s_ - back * period_s_, -bound, bound);
  time_s_ += to_time / total * error;
  period_s_ += to_period / total * error;
  time_time_ -= to_time * to_time / total;
  time_period_ -= to_time * to_period / total;
  period_period_ -= to_period * to_period / total;
}

bool PulseGrid::add_reported(std::int64_t pulse, double time_s, bool lights_on) noexcept {
  if (find(pulse) != nullptr && find(pulse)->time_s == time_s) return true;
  const bool follows = reported_ && pulse > last_.pulse && time_s > last_.time_s &&
                       static_cast<double>(pulse - last_.pulse) <=
                           kMostInNoTime + kMostOftenTheRate * (time_s - last_.time_s) / nominal_period_s_;
  if (!follows) {
    reports_.fill({});
    period_measured_ = false;
    period_s_ = nominal_period_s_;
  } else {
    const double measured = (time_s - last_.time_s) / static_cast<double>(pulse - last_.pulse);
    // Farther off: the board paused in between.
    if (std::abs(measured - period_s_) < 0.5 * period_s_) {
      period_s_ += (period_measured_ ? kPeriodGain : 1.0) * (measured - period_s_);
      period_measured_ = true;
    }
  }
  reported_ = true;
  last_ = {pulse, time_s, lights_on};
  reports_[static_cast<std::uint64_t>(pulse) % kReports] = last_;
  return follows;
}

const PulseGrid::Report* PulseGrid::find(std::int64_t pulse) const noexcept {
  if (!reported_ || pulse < 0) return nullptr;
  const Report& report = reports_[static_cast<std::uint64_t>(pulse) % kReports];
  return report.pulse == pulse ? &report : nullptr;
}

const PulseGrid::Report& PulseGrid::report_near(std::int64_t pulse) const noexcept {
  if (pulse >= last_.pulse) return last_;
  if (const Report* const exact = find(pulse)) return *exact;
  const Report* best = &last_;
  for (const Report& report : reports_) {
    if (report.pulse >= 0 && std::abs(report.pulse - pulse) < std::abs(best->pulse - pulse)) best = &report;
  }
  return *best;
}

double PulseGrid::time_s(std::int64_t pulse) const noexcept {
  if (!reported_) return time_s_ + static_cast<double>(pulse - pulse_) * period_s_;
  const Report& report = report_near(pulse);
  return report.time_s + static_cast<double>(pulse - report.pulse) * period_s_;
}

std::int64_t PulseGrid::nearest(double time_s) const noexcept {
  std::int64_t pulse = pulse_;
  double at_s = time_s_;
  if (reported_) {
    const Report* best = &last_;
    for (const Report& report : reports_) {
      if (report.pulse >= 0 && std::abs(report.time_s - time_s) < std::abs(best->time_s - time_s))
        best = &report;
    }
    pulse = best->pulse;
    at_s = best->time_s;
  }
  return pulse + std::llround((time_s - at_s) / period_s_);
}

double PulseGrid::variance_s2(std::int64_t pulse) const noexcept {
  if (reported_) return 0.0;
  const auto steps = static_cast<double>(pulse - pulse_);
  const double ahead = std::max(steps, 0.0) * kPeriodWander * nominal_period_s_;
  return time_time_ + steps * (2.0 * time_period_ + steps * period_period_) +
         ahead * ahead * std::max(steps, 0.0) / 3.0;
}

bool PulseGrid::credible(std::int64_t pulse) const noexcept {
  return !reported_ || pulse <= last_.pulse + kPulsesAhead;
}

bool PulseGrid::dark(std::int64_t pulse) const noexcept {
  const Report* const report = find(pulse);
  return report != nullptr && !report->lights_on;
}

}  // namespace glint
