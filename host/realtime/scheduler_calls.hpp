// SPDX-License-Identifier: MIT
// The system calls that real-time running makes, behind an interface: tests answer them.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

namespace glint {

/// Results are 0 or an errno. Any thread.
class SchedulerCalls {
 public:
  virtual ~SchedulerCalls() = default;
  /// The calling thread: SCHED_FIFO at that priority. Threads that it starts have the usual scheduling.
  virtual int set_fifo(int priority) noexcept = 0;
  /// The calling thread: only on these CPUs.
  virtual int pin(const std::vector<unsigned>& cpus) noexcept = 0;
  /// All memory of the process, now and later.
  virtual int lock_memory() noexcept = 0;
  /// Bytes that this process may lock; nothing: as many as it likes.
  virtual std::optional<std::uint64_t> memory_lock_limit() noexcept = 0;
  /// CPUs that the process may use, in order.
  virtual std::vector<unsigned> usable_cpus() noexcept = 0;
};

/// The real ones.
class KernelSchedulerCalls final : public SchedulerCalls {
 public:
  int set_fifo(int priority) noexcept override;
  int pin(const std::vector<unsigned>& cpus) noexcept override;
  int lock_memory() noexcept override;
  std::optional<std::uint64_t> memory_lock_limit() noexcept override;
  std::vector<unsigned> usable_cpus() noexcept override;
};

}  // namespace glint
