// SPDX-License-Identifier: MIT
// Threads that stay, and take the items of one job after the other together with the caller.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <thread>
#include <vector>

namespace glint::gpu {

/// A job is `items` calls of work(context, slot, item), each made once, by whichever thread is free.
/// Jobs are numbered by slots 0, 1, ... slots-1, 0, ...: start() takes them in that order, and a slot may be
/// started again once it was finished. start() and finish() are called by one thread. Nothing is
/// allocated after construction.
class Workers {
 public:
  using Work = void (*)(void* context, unsigned slot, unsigned item) noexcept;

  /// Throws Error when `helpers` threads cannot be started.
  Workers(unsigned helpers, unsigned slots, unsigned items, Work work, void* context);
  ~Workers();
  Workers(const Workers&) = delete;
  Workers& operator=(const Workers&) = delete;

  /// Publishes the next job; everything written before is seen by the threads that work on it.
  void start() noexcept;
  /// Works on the job in `slot` until it is done.
  void finish(unsigned slot) noexcept;

 private:
  struct alignas(64) Job {
    std::atomic<std::uint32_t> next{0xffff0000u};    // next item to take
    alignas(64) std::atomic<std::uint32_t> left{0};  // items not done
  };
  void take_items(unsigned slot) noexcept;
  void help() noexcept;
  void stop() noexcept;

  unsigned slots_, items_;
  Work work_;
  void* context_;
  std::unique_ptr<Job[]> jobs_;
  alignas(64) std::atomic<std::uint64_t> started_{
      0};  // 64 bits: never comes round, so job number modulo slots is the slot
  std::atomic<bool> stopping_{false};
  std::vector<std::jthread> helpers_;
};

}  // namespace glint::gpu
