// SPDX-License-Identifier: MIT
// Bounded queue between exactly one producer thread and one consumer thread, without locks on the way.
#pragma once

#include <atomic>
#include <cstddef>
#include <utility>
#include <vector>

namespace glint {

/// Slots are allocated once. push() and pop() are wait-free; wait_pop() sleeps until there is something
/// or close() was called.
template <typename T>
class Ring {
 public:
  explicit Ring(std::size_t capacity) : slots_(capacity + 1) {}

  /// Producer: moves `value` in; false (and `value` untouched) when full.
  [[nodiscard]] bool push(T&& value) noexcept {
    const std::size_t tail = tail_.load(std::memory_order_relaxed);
    const std::size_t next = (tail + 1) % slots_.size();
    if (next == head_.load(std::memory_order_acquire)) return false;
    slots_[tail] = std::move(value);
    tail_.store(next, std::memory_order_release);
    signal();
    return true;
  }

  /// Consumer: false when empty.
  [[nodiscard]] bool pop(T& value) noexcept {
    const std::size_t head = head_.load(std::memory_order_relaxed);
    if (head == tail_.load(std::memory_order_acquire)) return false;
    value = std::move(slots_[head]);
    head_.store((head + 1) % slots_.size(), std::memory_order_release);
    signal();
    return true;
  }

  /// Consumer: waits; false when closed and empty.
  [[nodiscard]] bool wait_pop(T& value) noexcept {
    for (;;) {
      const unsigned seen = changes_.load(std::memory_order_acquire);
      if (pop(value)) return true;
      if (closed_.load(std::memory_order_acquire)) return pop(value);
      changes_.wait(seen, std::memory_order_acquire);
    }
  }

  /// Producer: waits until there is room; false when closed.
  [[nodiscard]] bool wait_push(T&& value) noexcept {
    for (;;) {
      const unsigned seen = changes_.load(std::memory_order_acquire);
      if (closed_.load(std::memory_order_acquire)) return false;
      if (push(std::move(value))) return true;
      changes_.wait(seen, std::memory_order_acquire);
    }
  }

  /// Either side: no more pushes; what is inside can still be popped.
  void close() noexcept {
    closed_.store(true, std::memory_order_release);
    signal();
  }

  std::size_t size() const noexcept {
    const std::size_t head = head_.load(std::memory_order_acquire),
                      tail = tail_.load(std::memory_order_acquire);
    return (tail + slots_.size() - head) % slots_.size();
  }

 private:
  void signal() noexcept {
    // Sequentially consistent: notify_all() looks whether anybody waits, and that look must not be
    // moved before the change, or a thread that is just lying down is never woken.
    changes_.fetch_add(1, std::memory_order_seq_cst);
    changes_.notify_all();
  }

  std::vector<T> slots_;
  alignas(64) std::atomic<std::size_t> head_{0};
  alignas(64) std::atomic<std::size_t> tail_{0};
  alignas(64) std::atomic<unsigned> changes_{0};
  std::atomic<bool> closed_{false};
};

}  // namespace glint
