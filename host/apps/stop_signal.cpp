// SPDX-License-Identifier: MIT
// Waits for signals on a thread, so that no code runs in a signal handler.
#include "host/apps/stop_signal.hpp"

#include <pthread.h>
#include <unistd.h>

#include <ctime>
#include <utility>

namespace glint::apps {

StopSignal::StopSignal() {
  sigemptyset(&signals_);
  sigaddset(&signals_, SIGINT);
  sigaddset(&signals_, SIGTERM);
  pthread_sigmask(SIG_BLOCK, &signals_, &before_);
  thread_ = std::jthread([this](const std::stop_token& token) { watch(token); });
}

StopSignal::~StopSignal() {
  thread_.request_stop();
  thread_.join();
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void StopSignal::watch(const std::stop_token& token) {
  const timespec wait{0, 50'000'000};
  while (!token.stop_requested()) {
    const int signal = sigtimedwait(&signals_, nullptr, &wait);
    if (signal < 0) continue;
    const std::lock_guard lock(mutex_);
    if (!stop_ || stopping_) _exit(128 + signal);
    stopping_ = true;
    stop_();
  }
}

StopSignal::Handler::Handler(StopSignal& signal, std::function<void()> stop) : signal_(signal) {
  const std::lock_guard lock(signal_.mutex_);
  signal_.stop_ = std::move(stop);
}

StopSignal::Handler::~Handler() {
  const std::lock_guard lock(signal_.mutex_);
  signal_.stop_ = nullptr;
}

}  // namespace glint::apps
