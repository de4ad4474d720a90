// SPDX-License-Identifier: MIT
// Circular statistics to find the offset, Bayes' rule to place a frame, a scalar Kalman filter to follow the
// offset.
#include "host/assemble/camera_clock.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace glint {
namespace {

constexpr double kApart = 1.0;       // seconds between stamp and arrival that cannot be latency
constexpr double kEarly = 0.75;      // periods that a frame may arrive before its time
constexpr double kMargin = 13.8;     // ln(1e6): how much likelier the best pulse must be than the next best
constexpr double kNeverSent = 0.02;  // chance that the pulse before brought no frame and no gap
constexpr double kTwice = 0.01;      // chance that the pulse brought two frames
constexpr double kLeastWeight = 1e-9;
constexpr double kWidestGate = 6.0;      // standard deviations ...
constexpr double kNarrowestGate = 0.25;  // ... but at least so many periods
// Much may make a frame late, nothing makes it early: one that is may be a late one of the pulse before.
constexpr double kEarlyGate = 5.0;           // standard deviations of the normal part
constexpr double kLeastScatter = 1.0 / 400;  // of the period
constexpr double kScatterGain = 1.0 / 128, kScatterBound = 25.0;
// Errors are taken for the sum of a uniform and a normal one: rounded stamps are uniform. The fourth moment
// tells them apart, if it differs from a normal one's by more than chance and the fold at half a period
// explain.
constexpr double kFourthGain = 1.0 / 2048, kFourthChance = 0.5;
constexpr double kMostFlatScatter = 0.15;                         // of the period
constexpr double kLeastNormal = 0.1;                              // of the variance
constexpr double kLatencyGain = 1.0 / 64, kLatencyBound = 0.125;  // periods
// An offset wanders so much that it is followed within a second or two: stamps that are rounded to the period
// of USB transfers jump by up to that when trigger and bus drift past one another. While a camera is away its
// offset becomes no less certain than this, in periods.
constexpr double kOffsetMemory = 128.0, kLeastCertain = 0.05;
constexpr std::int64_t kSecondFrames = 2;
constexpr std::int64_t kLongestGap =
    1'000'000;  // farther apart, two sequence numbers are of different streams

double wrapped(double value, double period) noexcept { return value - period * std::round(value / period); }

}  // namespace

CameraClock::CameraClock(double period_s) noexcept : variance_(std::pow(kLeastScatter * period_s, 2)) {}

double CameraClock::on_host_clock(std::int64_t stamped_ns) const noexcept {
  // Unsigned: a driver's clock may wrap.
  return 1e-9 * static_cast<double>(static_cast<std::int64_t>(static_cast<std::uint64_t>(stamped_ns) +
                                                              static_cast<std::uint64_t>(moved_ns_)));
}

void CameraClock::collect(const FrameStamp& stamp, double usual_latency_s) noexcept {
  if (std::abs(stamp.arrived_s - on_host_clock(stamp.stamped_ns) - usual_latency_s) > kApart) {
    const auto should_be = static_cast<std::int64_t>(std::llround((stamp.arrived_s - usual_latency_s) * 1e9));
    moved_ns_ = static_cast<std::int64_t>(static_cast<std::uint64_t>(should_be) -
                                          static_cast<std::uint64_t>(stamp.stamped_ns));
    collected_ = 0;
  }
  if (last_) ++last_->delivered_since;
  const double stamped_s = on_host_clock(stamp.stamped_ns);
  samples_[collected_++ % kStamps] = {stamped_s, stamp.arrived_s - stamped_s, stamp.sequence};
}

CameraClock::Phase CameraClock::phase(const PulseGrid& grid) const noexcept {
  const double period = grid.period_s(), radians = 2.0 * std::numbers::pi / period;
  double x = 0.0, y = 0.0;
  for (std::size_t k = 0; k < kept(); ++k) {
    const double stamped = samples_[k].stamped_s;
    const double error = stamped - grid.time_s(grid.nearest(stamped));
    x += std::cos(radians * error);
    y += std::sin(radians * error);
  }
  const double length =
      std::clamp(std::hypot(x, y) / static_cast<double>(std::max<std::size_t>(kept(), 1)), 1e-9, 1.0);
  return {std::atan2(y, x) / radians, std::sqrt(-2.0 * std::log(length)) / radians};
}

bool CameraClock::ready(const PulseGrid& grid) const noexcept {
  return collected_ >= kStamps && phase(grid).scatter_s < kMostScatter * grid.period_s();
}

double CameraClock::middle_s() const noexcept {
  double sum = 0.0;
  for (std::size_t k = 0; k < kept(); ++k) sum += samples_[k].stamped_s;
  return sum / static_cast<double>(std::max<std::size_t>(kept(), 1));
}

void CameraClock::lock(const PulseGrid& grid, double usual_offset_s) noexcept {
  const double period = grid.period_s();
  const Phase found = phase(grid);
  const double usual = usual_offset_s + shifted_s(grid);
  offset_s_ = usual + wrapped(found.mean_s - usual, period);
  // Half as much again: so few stamps may flatter.
  variance_ = 1.5 * std::pow(std::max(found.scatter_s, kLeastScatter * period), 2);
  offset_variance_ = variance_ / static_cast<double>(kStamps);
  slow_variance_ = variance_;
  fourth_ = 3.0 * variance_ * variance_;
  std::array<double, kStamps> latency;
  for (std::size_t k = 0; k < kStamps; ++k) latency[k] = samples_[k].latency_s;
  std::nth_element(latency.begin(), latency.begin() + kStamps / 2, latency.end());
  latency_s_ = latency[kStamps / 2];
  locked_ = latency_known_ = true;
  unplaced_ = 0;
  learnt_at_ = newest_collected(grid);
}

void CameraClock::unlock() noexcept {
  belief_.reset();
  locked_ = false;
  collected_ = 0;
  unplaced_ = 0;
}

std::int64_t CameraClock::newest_collected(const PulseGrid& grid) const noexcept {
  return grid.nearest(samples_[(collected_ - 1) % kStamps].stamped_s - offset_s_);
}

void CameraClock::count_from(const PulseGrid& grid) noexcept {
  last_ = Last{newest_collected(grid), samples_[(collected_ - 1) % kStamps].sequence, 0};
  belief_.reset();
}

/// Chance that a frame with that sequence number is of that pulse, before its stamp is looked at.
double CameraClock::prior(std::int64_t pulse, std::uint32_t sequence) const noexcept {
  if (!belief_) return 1.0;
  const std::int64_t ahead = static_cast<std::int32_t>(sequence - belief_->sequence);
  double sum = 0.0;
  for (std::size_t k = 0; k < kCandidates; ++k) {
    const std::int64_t unless_lost = belief_->first + static_cast<std::int64_t>(k) + ahead;
    const double chance = pulse == unless_lost ? 1.0 : pulse > unless_lost ? kNeverSent : kTwice;
    sum += belief_->weight[k] * chance;
  }
  return sum;
}

std::optional<Placement> CameraClock::place(const PulseGrid& grid, const FrameStamp& stamp) noexcept {
  const double stamped = on_host_clock(stamp.stamped_ns), period = grid.period_s();
  const double late = stamp.arrived_s - stamped - latency_s_;
  const auto give_up = [this] {
    ++unplaced_;
    if (last_) ++last_->delivered_since;
    return std::nullopt;
  };
  if (late < -kEarly * period || late > kApart) return give_up();

  // Bayes' rule over the nearest pulse and its neighbours.
  const std::int64_t nearest = grid.nearest(stamped - offset_s_);
  const double flat = flat_s(period);
  const double normal = std::max(variance_ - flat * flat / 3.0, kLeastNormal * variance_);
  const double more = offset_variance_ + grid.variance_s2(nearest);
  const auto error = [&](std::int64_t pulse) { return stamped - offset_s_ - grid.time_s(pulse); };
  Belief belief{nearest - 1, stamp.sequence, {}};
  std::array<double, kCandidates> score;
  for (std::size_t k = 0; k < kCandidates; ++k) {
    const std::int64_t pulse = belief.first + static_cast<std::int64_t>(k);
    const double outside = std::max(std::abs(error(pulse)) - flat, 0.0);
    score[k] = std::log(prior(pulse, stamp.sequence)) - 0.5 * outside * outside / (normal + more);
  }
  const auto best = static_cast<std::size_t>(std::max_element(score.begin(), score.end()) - score.begin());
  double next_score = -1e300;
  for (std::size_t k = 0; k < kCandidates; ++k) {
    if (k != best) next_score = std::max(next_score, score[k]);
    belief.weight[k] = std::max(std::exp(score[k] - score[best]), kLeastWeight);
  }
  const std::int64_t pulse = belief.first + static_cast<std::int64_t>(best);
  const bool overtaken =
      last_ && pulse <= last_->pulse && static_cast<std::int32_t>(stamp.sequence - last_->sequence) < 0;
  if (!overtaken) belief_ = belief;

  const double gate = std::max(kNarrowestGate * period, kWidestGate * std::sqrt(variance_ + more));
  const double earliest = -std::min(gate, flat + kEarlyGate * std::sqrt(normal + more));
  const bool fits = error(pulse) >= earliest && error(pulse) <= gate;
  if (score[best] - next_score < kMargin || !fits || !grid.credible(pulse)) {
    learn_scatter(error(nearest), period);
    return give_up();
  }
  return placed(pulse, stamped, stamp.sequence);
}

Placement CameraClock::placed(std::int64_t pulse, double stamped_s, std::uint32_t sequence) noexcept {
  unplaced_ = 0;
  Placement result{pulse, stamped_s, pulse, 0, false, false};
  const std::int64_t ahead = last_ ? static_cast<std::int32_t>(sequence - last_->sequence) : 0;
  result.regular = last_ && ahead != 0 && pulse - last_->pulse == ahead;
  if (last_ && ahead < 0 && pulse <= last_->pulse) {  // the newer one stays the last
    result.out_of_order = true;
    return result;
  }
  if (last_ && ahead > 0 && ahead < kLongestGap && pulse > last_->pulse) {
    const std::int64_t gap = ahead - 1 - std::int64_t{last_->delivered_since};
    const std::int64_t missing = pulse - last_->pulse - 1;
    result.after = last_->pulse;
    // A gap longer than time allows: the stream was started anew, and says nothing of losses. A little
    // longer: second frames of a pulse were lost too.
    if (gap > 0 && gap <= missing + kSecondFrames) {
      result.lost_by_host = static_cast<std::uint64_t>(std::min(gap, missing));
    }
  }
  last_ = Last{pulse, sequence, 0};
  return result;
}

void CameraClock::learn_scatter(double error_s, double period_s) noexcept {
  const double square = std::min(error_s * error_s, kScatterBound * variance_);
  variance_ += kScatterGain * (square - variance_);
  variance_ = std::max(variance_, std::pow(kLeastScatter * period_s, 2));
  slow_variance_ += kFourthGain * (square - slow_variance_);
  fourth_ += kFourthGain * (square * square - fourth_);
}

/// Half-width of the uniform part of the errors.
double CameraClock::flat_s(double period_s) const noexcept {
  if (variance_ > std::pow(kMostFlatScatter * period_s, 2)) return 0.0;
  const double lacking = (3.0 - kFourthChance) * slow_variance_ * slow_variance_ - fourth_;
  const double flat = std::pow(7.5 * std::max(lacking, 0.0), 0.25);
  return std::min(flat, std::sqrt(3.0 * variance_));
}

double CameraClock::learn(PulseGrid& grid, const Placement& placement, double arrived_s) noexcept {
  const double period = grid.period_s();
  learn_scatter(placement.stamped_s - offset_s_ - grid.time_s(placement.pulse), period);
  const double late = arrived_s - placement.stamped_s - latency_s_;
  latency_s_ += kLatencyGain * std::clamp(late, -kLatencyBound * period, kLatencyBound * period);

  if (!grid.reported())
    grid.observe(placement.pulse, placement.stamped_s - offset_s_, variance_ + offset_variance_);
  const auto steps = static_cast<double>(std::max<std::int64_t>(placement.pulse - learnt_at_, 0));
  learnt_at_ = std::max(learnt_at_, placement.pulse);
  offset_variance_ = std::min(offset_variance_ + steps * variance_ / (kOffsetMemory * kOffsetMemory),
                              std::max(offset_variance_, std::pow(kLeastCertain * period, 2)));
  const double total = offset_variance_ + variance_ + grid.variance_s2(placement.pulse);
  const double gain = offset_variance_ / total, bound = 3.0 * std::sqrt(total);
  const double error = placement.stamped_s - offset_s_ - grid.time_s(placement.pulse);
  const double moved = gain * std::clamp(error, -bound, bound);
  offset_variance_ *= 1.0 - gain;
  offset_s_ += moved;
  return moved;
}

void CameraClock::shift(const PulseGrid& grid, int pulses) noexcept {
  shift_ += pulses;
  offset_s_ -= pulses * grid.period_s();
  if (last_) last_->pulse += pulses;
  if (belief_) belief_->first += pulses;
}

double CameraClock::scatter_s() const noexcept { return std::sqrt(variance_ + offset_variance_); }

double CameraClock::expected_s(const PulseGrid& grid, std::int64_t pulse) const noexcept {
  return grid.time_s(pulse) + offset_s_ + latency_s_;
}

}  // namespace glint
