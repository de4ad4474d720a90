// SPDX-License-Identifier: MIT
// What the host wants the outputs to do, and whether the board will.
#pragma once

#include "firmware/core/limits.hpp"
#include "firmware/protocol/sync_report.h"

namespace glint::board {

constexpr bool is_strobe(unsigned output) { return output >= GLINT_SYNC_TRIGGERS; }

/// Settings as they came over the wire.
struct Plan {
  glint_sync_run run{};
  glint_sync_output outputs[GLINT_SYNC_OUTPUTS]{};

  bool external() const { return (run.flags & GLINT_SYNC_RUN_EXTERNAL) != 0; }
  bool enabled(unsigned output) const { return (outputs[output].flags & GLINT_SYNC_OUTPUT_ENABLED) != 0; }
  bool active_low(unsigned output) const {
    return (outputs[output].flags & GLINT_SYNC_OUTPUT_ACTIVE_LOW) != 0;
  }
};

/// Nothing enabled, 90 Hz.
Plan default_plan();

struct Refusal {
  uint8_t reason = GLINT_SYNC_REFUSED_NOTHING;
  uint8_t output = 0xff;
  uint32_t limit = 0;

  explicit operator bool() const { return reason != GLINT_SYNC_REFUSED_NOTHING; }
};

/// The first thing wrong with a plan, if any. `strobes_active_low` is what the jumper says.
Refusal check(const Plan& plan, const StrobeLimits& limits, bool strobes_active_low);

}  // namespace glint::board
