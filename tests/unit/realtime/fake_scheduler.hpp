// SPDX-License-Identifier: MIT
// A kernel that permits what a test tells it to.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "host/realtime/scheduler_calls.hpp"

namespace glint::test {

class FakeScheduler final : public SchedulerCalls {
 public:
  int highest_priority = 99;  ///< more is refused with EPERM
  int lock_error = 0, pin_error = 0;
  std::optional<std::uint64_t> lock_limit;
  std::vector<unsigned> cpus{0, 1, 2, 3};

  int set_fifo(int priority) noexcept override;
  int pin(const std::vector<unsigned>& wanted) noexcept override;
  int lock_memory() noexcept override;
  std::optional<std::uint64_t> memory_lock_limit() noexcept override { return lock_limit; }
  std::vector<unsigned> usable_cpus() noexcept override { return cpus; }

  /// What the calling thread was given.
  int fifo_here() const;
  int locks = 0;
  std::vector<std::vector<unsigned>> pins;

 private:
  mutable std::mutex mutex_;
  std::vector<std::pair<std::thread::id, int>> fifo_;
};

}  // namespace glint::test
