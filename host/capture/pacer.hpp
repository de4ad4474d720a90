// SPDX-License-Identifier: MIT
// When a recorded frame set is due, and the wait until then.
#pragma once

#include <cstdint>
#include <optional>
#include <stop_token>

#include "host/base/ids.hpp"
#include "host/frames/source.hpp"

namespace glint {

enum class Pace : std::uint8_t {
  AsRecorded,  ///< the distances of the exposure times
  Rate,        ///< the distances of the trigger numbers, at a given rate
  Fastest,     ///< no waiting
};

struct PaceOptions {
  Pace pace = Pace::AsRecorded;
  double rate_hz = 0.0;  ///< for Pace::Rate
};

/// How late sets were delivered; a set that is handed over before it is due is not late.
struct Lateness {
  std::uint64_t sets = 0;  ///< paced so far
  std::uint64_t late = 0;  ///< by more than a millisecond
  double max_s = 0.0;
};

/// Keeps an absolute schedule: a late set does not move those after it. Thread-bound.
class Pacer {
 public:
  /// Throws Error for Pace::Rate without a rate.
  explicit Pacer(const PaceOptions& options);

  /// When this set is due. The first set seen is due at `now` and fixes the schedule.
  Timestamp due(TriggerNo trigger, Timestamp exposed, Timestamp now) noexcept;
  Timestamp due(const FrameSet& set) noexcept;
  Timestamp due(const BlobSet& set) noexcept;

  /// Sleeps until then (CLOCK_MONOTONIC, absolute) or until a stop is asked for, which it notices within 50
  /// ms. Returns how late it is, in seconds, and counts it.
  double wait(Timestamp due, const std::stop_token& stop = {}) noexcept;

  const Lateness& lateness() const noexcept { return lateness_; }

 private:
  struct Origin {
    TriggerNo trigger;
    Timestamp exposed, started;
  };
  PaceOptions options_;
  std::optional<Origin> origin_;
  Lateness lateness_;
};

}  // namespace glint
