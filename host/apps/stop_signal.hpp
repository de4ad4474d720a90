// SPDX-License-Identifier: MIT
// Ctrl-C ends a run cleanly; a second one, or one before there is anything to end, at once.
#pragma once

#include <csignal>
#include <functional>
#include <mutex>
#include <thread>

namespace glint::apps {

/// While it lives, SIGINT and SIGTERM go to a thread of its own. Make it before any other thread, so that
/// they inherit the blocked signals.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;

  /// While it lives, the first signal calls `stop` instead of ending the program. Make it after what `stop`
  /// uses.
  class Handler {
   public:
    Handler(StopSignal& signal, std::function<void()> stop);
    ~Handler();
    Handler(const Handler&) = delete;
    Handler& operator=(const Handler&) = delete;

   private:
    StopSignal& signal_;
  };

 private:
  void watch(const std::stop_token& token);

  sigset_t signals_{}, before_{};
  std::mutex mutex_;            // guards stop_, and that it is not called once its Handler is gone
  std::function<void()> stop_;  // empty: end the program
  bool stopping_ = false;
  std::jthread thread_;
};

}  // namespace glint::apps
