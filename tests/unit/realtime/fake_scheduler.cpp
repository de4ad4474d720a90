// SPDX-License-Identifier: MIT
// Answers as the kernel does.
#include "tests/unit/realtime/fake_scheduler.hpp"

#include <cerrno>

namespace glint::test {

int FakeScheduler::set_fifo(int priority) noexcept {
  if (priority > highest_priority) return EPERM;
  const std::lock_guard lock(mutex_);
  fifo_.emplace_back(std::this_thread::get_id(), priority);
  return 0;
}

int FakeScheduler::pin(const std::vector<unsigned>& wanted) noexcept {
  const std::lock_guard lock(mutex_);
  if (pin_error == 0) pins.push_back(wanted);
  return pin_error;
}

int FakeScheduler::lock_memory() noexcept {
  if (lock_error == 0) ++locks;
  return lock_error;
}

int FakeScheduler::fifo_here() const {
  const std::lock_guard lock(mutex_);
  int priority = 0;
  for (const auto& [thread, given] : fifo_) {
    if (thread == std::this_thread::get_id()) priority = given;
  }
  return priority;
}

}  // namespace glint::test
