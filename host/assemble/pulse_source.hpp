// SPDX-License-Identifier: MIT
// Pulses that somebody knows to have been fired, as the assembler wants them.
#pragma once

#include "host/base/ids.hpp"

namespace glint {

/// One exposure of all cameras.
struct FiredPulse {
  TriggerNo trigger{};   ///< counted from 0 in each run of the board
  Timestamp exposed;     ///< beginning of the exposure
  double error_s = 0.0;  ///< half-width of an interval about it that holds the truth
  bool lights_on = true;
};

/// Fires pulses while cameras stream, and tells of each. begin() and end() come from the thread that calls
/// take(), or before and after it.
class PulseSource {
 public:
  virtual ~PulseSource() = default;
  /// The cameras wait for pulses. Throws what is derived from std::runtime_error.
  virtual void begin() = 0;
  /// They do not any more.
  virtual void end() noexcept = 0;
  /// The next pulse in order; false: none that is not taken yet. Gaps in `trigger` are pulses nobody told of.
  [[nodiscard]] virtual bool take(FiredPulse& pulse) noexcept = 0;
};

}  // namespace glint
