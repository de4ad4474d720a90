// SPDX-License-Identifier: MIT
// Items are taken by counting up; waiting is a short spin, then sleep.
#include "gpu/cpu/workers.hpp"

#include <system_error>

#include "gpu/detector.hpp"

namespace glint::gpu {
namespace {

/// Longest spin before a thread sleeps. It saves waking a thread when jobs follow each other at once, and
/// is short against any frame period.
constexpr int kSpins = 1500;

void spin_once() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Waits until `value` is no longer `old`.
template <typename T>
void wait_for_change(std::atomic<T>& value, T old) noexcept {
  for (int i = 0; i < kSpins; ++i) {
    if (value.load(std::memory_order_acquire) != old) return;
    spin_once();
  }
  value.wait(old, std::memory_order_acquire);
}

}  // namespace

Workers::Workers(unsigned helpers, unsigned slots, unsigned items, Work work, void* context)
    : slots_(slots), items_(items), work_(work), context_(context), jobs_(std::make_unique<Job[]>(slots)) {
  try {
    for (unsigned i = 0; i < helpers; ++i) helpers_.emplace_back([this] { help(); });
  } catch (const std::system_error& error) {
    stop();
    throw Error("detector: cannot start " + std::to_string(helpers) + " threads (" + error.what() +
                "); ask for fewer threads");
  }
}

Workers::~Workers() { stop(); }

void Workers::stop() noexcept {
  stopping_.store(true, std::memory_order_release);
  started_.fetch_add(1, std::memory_order_acq_rel);
  started_.notify_all();
  helpers_.clear();  // joins
}

void Workers::start() noexcept {
  Job& job = jobs_[started_.load(std::memory_order_relaxed) % slots_];
  job.left.store(items_, std::memory_order_relaxed);
  // A helper that comes late from an earlier job in this slot may take items of this one: whoever reads
  // this zero, or a count that goes back to it, sees the whole job.
  job.next.store(0, std::memory_order_release);
  started_.fetch_add(1, std::memory_order_acq_rel);
  if (!helpers_.empty()) started_.notify_all();
}

void Workers::take_items(unsigned slot) noexcept {
  Job& job = jobs_[slot];
  for (;;) {
    // Read first, so that threads that find nothing do not count up for ever.
    if (job.next.load(std::memory_order_relaxed) >= items_) return;
    const std::uint32_t item = job.next.fetch_add(1, std::memory_order_acq_rel);
    if (item >= items_) return;
    work_(context_, slot, item);
    if (job.left.fetch_sub(1, std::memory_order_acq_rel) == 1) job.left.notify_all();
  }
}

void Workers::finish(unsigned slot) noexcept {
  take_items(slot);
  for (std::uint32_t left; (left = jobs_[slot].left.load(std::memory_order_acquire)) != 0;) {
    wait_for_change(jobs_[slot].left, left);
  }
}

void Workers::help() noexcept {
  std::uint64_t seen = 0;
  for (;;) {
    while (started_.load(std::memory_order_acquire) == seen) wait_for_change(started_, seen);
    if (stopping_.load(std::memory_order_acquire)) return;
    take_items(static_cast<unsigned>(seen % slots_));
    ++seen;
  }
}

}  // namespace glint::gpu
