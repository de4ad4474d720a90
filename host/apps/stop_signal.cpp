// SPDX-License-Identifier: MIT
// Waits for signals on a thread, so that no code runs in a signal handler.
#include "host/apps/stop_signal.hpp"

#include <pthread.h>

#include <ctime>
#include <utility>

namespace glint::apps {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
}

StopSignal::~StopSignal() {
  if (thread_.joinable()) {
    thread_.request_stop();
    thread_.join();
  }
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void StopSignal::on_stop(std::function<void()> stop) {
  thread_ = std::jthread([signals = signals_, stop = std::move(stop)](const std::stop_token& token) {
    const timespec wait{0, 100'000'000};
    while (!token.stop_requested()) {
      if (sigtimedwait(&signals, nullptr, &wait) < 0) continue;
      stop();
      pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);  // the next one ends the program
      return;
    }
  });
}

}  // namespace glint::apps
