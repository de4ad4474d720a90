// SPDX-License-Identifier: MIT
// Mesa's CPU driver ends the loops of an invocation, silently, after 65 535 turns in all: count those without a bound, stop
// well before, and say so.
layout(constant_id = 4) const uint kMostTurns = 60000u;
uint turns_left = kMostTurns;

bool has_turns() { return turns_left != 0u; }

// False: stop now.
bool spend_turn() {
  turns_left -= min(turns_left, 1u);
  return turns_left != 0u;
}
