// SPDX-License-Identifier: MIT
// Draws of the faults.
#include "host/sim/faults.hpp"

#include "host/sim/random.hpp"

namespace glint::sim {
namespace {

bool happens(const SimOptions& options, Stream stream, double rate, std::uint32_t camera,
             std::uint64_t tick) noexcept {
  if (rate <= 0.0) return false;
  const std::uint64_t bits = stream_seed(options.seed, stream, camera, tick);
  return static_cast<double>(bits >> 11) * 0x1p-53 < rate;
}

Fate alone(const SimOptions& options, std::uint32_t camera, std::uint64_t tick) noexcept {
  const SimFaults& faults = options.faults;
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

}  // namespace glint::sim
