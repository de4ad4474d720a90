// SPDX-License-Identifier: MIT
// Draws of the faults.
#include "host/sim/faults.hpp"

#include <algorithm>
#include <cmath>

namespace glint::sim {
namespace {

bool below(double rate, std::uint64_t bits) noexcept {
  return static_cast<double>(bits >> 11) * 0x1p-53 < rate;
}

bool happens(const SimOptions& options, Stream stream, double rate, std::uint32_t camera,
             std::uint64_t tick) noexcept {
  return rate > 0.0 && below(rate, stream_seed(options.seed, stream, camera, tick));
}

bool is_off(const SimFaults& faults, std::uint32_t camera, std::uint64_t tick) noexcept {
  return std::any_of(faults.off.begin(), faults.off.end(), [&](const SimOff& off) {
    return off.camera == camera && tick >= off.tick && tick - off.tick < off.ticks;
  });
}

/// Knuth's way, which multiplies uniform numbers; the means here are small.
std::uint32_t poisson(Random& random, double mean, std::uint32_t most) noexcept {
  const double limit = std::exp(-mean);
  std::uint32_t count = 0;
  for (double product = random.uniform(); product > limit && count < most; product *= random.uniform()) {
    ++count;
  }
  return count;
}

Fate alone(const SimOptions& options, std::uint32_t camera, std::uint64_t tick) noexcept {
  const SimFaults& faults = options.faults;
  if (is_off(faults, camera, tick)) return Fate::Dropped;
  if (happens(options, Stream::Drop, faults.drop_rate, camera, tick)) return Fate::Dropped;
  // A set is closed half a period after its exposure; what is less late than that still comes in time.
  const bool too_late = faults.late_s > 0.5 / options.rate_hz;
  if (too_late && happens(options, Stream::Late, faults.late_rate, camera, tick)) return Fate::Late;
  if (tick > 0 && happens(options, Stream::Duplicate, faults.duplicate_rate, camera, tick))
    return Fate::Duplicated;
  return Fate::Fine;
}

}  // namespace

Fate fate(const SimOptions& options, std::uint32_t camera, std::uint64_t tick) noexcept {
  const Fate own = alone(options, camera, tick);
  if (own == Fate::Duplicated && alone(options, camera, tick - 1) != Fate::Fine) return Fate::Fine;
  return own;
}

bool missing(const SimOptions& options, std::uint32_t camera, std::uint64_t tick,
             std::uint32_t marker) noexcept {
  const double rate = options.faults.missing_rate;
  return rate > 0.0 && below(rate, mix(stream_seed(options.seed, Stream::Missing, camera, tick) ^ marker));
}

Blinks::Blinks(const SimOptions& options, std::uint32_t camera, std::uint64_t tick) noexcept
    : random_(stream_seed(options.seed, Stream::Blinks, camera, tick)),
      width_px_(options.width_px),
      height_px_(options.height_px) {
  if (options.faults.blinks_per_frame > 0.0)
    count_ = poisson(random_, options.faults.blinks_per_frame, kMost);
}

Blink Blinks::next() noexcept {
  Blink blink;
  blink.size_px = random_.uniform() < 0.5 ? 1 : 2;
  blink.x_px = static_cast<int>(random_.uniform() * (width_px_ - 1));
  blink.y_px = static_cast<int>(random_.uniform() * (height_px_ - 1));
  blink.grey = static_cast<std::uint8_t>(random_.uniform(60.0, 256.0));
  return blink;
}

}  // namespace glint::sim
