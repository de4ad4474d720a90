// SPDX-License-Identifier: MIT
// The self-test of the sync board, output by output: a wire to sync in, pulses, what the board measured.
#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "usb-sync/board_state.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint::apps {

struct SelfTestOptions {
  std::vector<std::size_t> outputs;
  /// Waits for a wire from each output to sync in; otherwise tests each once, as it is wired now.
  bool wait_for_wires = true;
};

/// For the person at the board: what to do, or what came of it. Whole lines.
using SayLine = std::function<void(const std::string& line)>;

/// One result for each output, in that order; `seen` is 0 where there was no wire. Throws as
/// SyncBoard::self_test().
std::vector<sync::SelfTestResult> run_self_tests(sync::SyncBoard& board, const SelfTestOptions& options,
                                                 const SayLine& say);

/// "output 4 (strobe), GP6: passed, 32 of 32 pulses; width 137.000 us, -0.008 to +0.000 us off ...".
std::string self_test_text(const sync::SelfTestResult& result);

/// What stands against calling the test passed; "" if nothing does. `named`: the person chose the outputs, so
/// that one without a wire counts as failed; otherwise at least one must have had a wire.
std::string self_test_verdict(const std::vector<sync::SelfTestResult>& results, bool named);

}  // namespace glint::apps
