// SPDX-License-Identifier: MIT
// Ctrl-C ends a run cleanly; a second one at once.
#pragma once

#include <csignal>
#include <functional>
#include <thread>

namespace glint::apps {

/// While it lives, SIGINT and SIGTERM call `stop` (on a thread of its own) instead of ending the program.
/// Make it before any other thread, so that they inherit the blocked signals.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  /// From now on. Once.
  void on_stop(std::function<void()> stop);

 private:
  sigset_t signals_{}, before_{};
  std::jthread thread_;
};

}  // namespace glint::apps
