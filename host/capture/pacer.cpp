// SPDX-License-Identifier: MIT
// The schedule of a recording: absolute times, one clock.
#include "host/capture/pacer.hpp"

#include <time.h>

#include <algorithm>
#include <chrono>

#include "host/base/error.hpp"

namespace glint {
namespace {

constexpr double kLateFrom_s = 1e-3;  // below this it is the scheduler, not the work
constexpr std::chrono::milliseconds kLongestNap{50};
// A stray time stamp must not overflow the clock: nothing is due later than a century from the start.
constexpr double kLongestSchedule_s = 3.15e9;

void sleep_until(Timestamp until) noexcept {
  const auto since_epoch = until.time_since_epoch();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(since_epoch);
  timespec at{};
  at.tv_sec = static_cast<time_t>(seconds.count());
  at.tv_nsec = static_cast<long>(std::chrono::nanoseconds(since_epoch - seconds).count());
  // An interrupted sleep returns early; wait() looks at the clock and goes on.
  clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr);
}

}  // namespace

Pacer::Pacer(const PaceOptions& options) : options_(options) {
  if (options.pace == Pace::Rate && !(options.rate_hz > 0.0)) {
    throw Error("pacing at a rate needs a rate above 0 Hz");
  }
}

Timestamp Pacer::due(TriggerNo trigger, Timestamp exposed, Timestamp now) noexcept {
  if (options_.pace == Pace::Fastest) return now;
  if (!origin_) origin_ = Origin{trigger, exposed, now};
  double after_s = 0.0;
  if (options_.pace == Pace::AsRecorded) {
    after_s = seconds_between(origin_->exposed, exposed);
  } else {
    const std::uint64_t first = number(origin_->trigger), current = number(trigger);
    const double steps =
        current >= first ? static_cast<double>(current - first) : -static_cast<double>(first - current);
    after_s = steps / options_.rate_hz;
  }
  after_s = std::clamp(after_s, 0.0, kLongestSchedule_s);
  return origin_->started +
         std::chrono::duration_cast<Timestamp::duration>(std::chrono::duration<double>(after_s));
}

Timestamp Pacer::due(const FrameSet& set) noexcept {
  return due(set.trigger, set.exposed, std::chrono::steady_clock::now());
}

Timestamp Pacer::due(const BlobSet& set) noexcept {
  return due(set.trigger, set.exposed, std::chrono::steady_clock::now());
}

double Pacer::wait(Timestamp due, const std::stop_token& stop) noexcept {
  Timestamp now = std::chrono::steady_clock::now();
  const double late_s = std::max(0.0, seconds_between(due, now));
  while (now < due && !stop.stop_requested()) {
    sleep_until(std::min(due, now + kLongestNap));
    now = std::chrono::steady_clock::now();
  }
  ++lateness_.sets;
  if (late_s > kLateFrom_s) ++lateness_.late;
  lateness_.max_s = std::max(lateness_.max_s, late_s);
  return late_s;
}

}  // namespace glint
