// SPDX-License-Identifier: MIT
#include "usb-sync/clock_model.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace glint::sync {
namespace {

/// The hulls are looked at from a new place when the newest inequality is so far from the last.
constexpr double kStep_s = 0.05;
/// Delays are remembered for so long.
constexpr double kMemory_s = 10.0;
/// Further than any line can be from where it is looked for: what is cut off first.
constexpr double kAnywhere_s = 1e3;

std::chrono::nanoseconds rounded(double seconds) noexcept {
  constexpr double kMost_s = 1e9;  // ticks come over the wire: nonsense must not overflow
  return std::chrono::nanoseconds(std::llround(1e9 * std::clamp(seconds, -kMost_s, kMost_s)));
}

double margin_s(double max_bend, double distance_s) noexcept {
  return 0.5 * max_bend * distance_s * distance_s;
}

}  // namespace

void ClockModel::Delays::add(double delay_s) noexcept {
  count += 1.0;
  sum_s += std::abs(delay_s);
}

/// The mean gap between delays that fill their range evenly. How tight a hull becomes goes with a lower power
/// of it, as it is made of the inequalities of a longer time if there are few; the root fits what was
/// simulated.
double ClockModel::Delays::slack() const noexcept {
  constexpr double kLeast_s = 1e-9;
  return std::sqrt(std::max(sum_s, kLeast_s)) / std::max(count, 1e-3);
}

ClockModel::ClockModel(std::uint32_t tick_hz, const ClockOptions& options) noexcept
    : options_(options),
      tick_s_(1.0 / tick_hz),
      upper_(Envelope::Side::Below, options.max_rate_change_per_s),
      lower_(Envelope::Side::Above, options.max_rate_change_per_s) {}

void ClockModel::add(const TimeAnswer& answer) noexcept {
  if (!known_ || answer.epoch != last_.epoch || answer.tick < last_.tick) {
    restart(answer);
    return;
  }
  last_ = answer;
  if (!observe(lower_, answer.tick, answer.asked + rounded(options_.least_request.count())) ||
      !observe(upper_, answer.tick, answer.answered - rounded(options_.least_answer.count()))) {
    ++contradictions_;
    restart(answer);
  }
}

void ClockModel::add_arrival(std::uint64_t tick, HostTime arrival) noexcept {
  if (!known_) return;
  if (observe(upper_, tick, arrival - rounded(options_.least_answer.count()))) return;
  ++contradictions_;
  restart(last_);
}

std::optional<HostInterval> ClockModel::at(std::uint64_t tick) const noexcept {
  if (!known_) return std::nullopt;
  const double x = x_of(tick);
  const FeasibleLines::Range range = lines_.at(x - view_x_);
  const double y = estimate(x);
  const double farthest = std::max(range.most + view_y_ - y, y - range.least - view_y_);
  return HostInterval{origin_time_ + rounded(x + y),
                      Seconds(farthest + margin_s(options_.max_rate_change_per_s, x - view_x_))};
}

double ClockModel::rate_error() const noexcept {
  if (!known_) return 0.0;
  const FeasibleLines::Range range = lines_.rate();
  return 0.5 * (range.least + range.most);
}

void ClockModel::restart(const TimeAnswer& answer) noexcept {
  known_ = true;
  last_ = answer;
  origin_tick_ = answer.tick;
  origin_time_ = answer.asked;
  upper_.clear();
  lower_.clear();
  after_ = before_ = {};
  double asked = options_.least_request.count();
  double answered = Seconds(answer.answered - answer.asked - options_.least_answer).count();
  if (answered <= asked) {  // quicker than any wire
    asked = 0.0;
    answered = Seconds(answer.answered - answer.asked).count();
  }
  lower_.add({0.0, asked});
  upper_.add({0.0, answered});
  view_x_ = 0.0;
  view_y_ = asked;
  lines_.start({0.0, answered - asked}, {-options_.max_rate_error, options_.max_rate_error});
}

/// Takes an inequality in; false if no line is left. Then the model is to be restarted.
bool ClockModel::observe(Envelope& envelope, std::uint64_t tick, HostTime bound) noexcept {
  const double x = x_of(tick);
  const Envelope::Point point{x, Seconds(bound - origin_time_).count() - x};
  (&envelope == &upper_ ? after_ : before_).add(point.y - estimate(x));
  envelope.add(point);
  return x - view_x_ < kStep_s ? narrow(envelope, point) : look_from(x);
}

/// Cuts the lines by one inequality. It holds for tangents, once it is wider by what the curve can have bent.
bool ClockModel::narrow(const Envelope& envelope, Envelope::Point point) noexcept {
  const double x = point.x - view_x_, y = point.y - view_y_;
  const double margin = margin_s(options_.max_rate_change_per_s, x);
  return &envelope == &upper_ ? lines_.keep_below(x, y + margin) : lines_.keep_above(x, y - margin);
}

/// The tangents at x, from all inequalities that matter; the newest cut most, so they come first.
bool ClockModel::look_from(double x) noexcept {
  const double kept = std::exp((view_x_ - x) / kMemory_s);
  for (Delays* delays : {&after_, &before_}) {
    delays->count *= kept;
    delays->sum_s *= kept;
  }
  view_y_ = estimate(x);
  view_x_ = x;
  lines_.start({-kAnywhere_s, kAnywhere_s}, {-options_.max_rate_error, options_.max_rate_error});
  const std::size_t most = std::max(upper_.points().size(), lower_.points().size());
  for (std::size_t back = 1; back <= most; ++back) {
    for (const Envelope* envelope : {&upper_, &lower_}) {
      const auto points = envelope->points();
      if (back <= points.size() && !narrow(*envelope, points[points.size() - back])) return false;
    }
  }
  return true;
}

double ClockModel::x_of(std::uint64_t tick) const noexcept {
  return tick_s_ * static_cast<double>(static_cast<std::int64_t>(tick - origin_tick_));
}

/// Within what is possible, nearer to the side about which more is known.
double ClockModel::estimate(double x) const noexcept {
  const FeasibleLines::Range range = lines_.at(x - view_x_);
  const double above = after_.slack(), below = before_.slack();
  return view_y_ + range.most - (range.most - range.least) * above / (above + below);
}

}  // namespace glint::sync
