// SPDX-License-Identifier: MIT
// Asks first, then does what is permitted.
#include "host/realtime/real_time.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "host/base/error.hpp"
#include "host/realtime/cpu_list.hpp"

namespace glint {
namespace {

constexpr std::size_t kStackTouched = 256 * 1024;  // several times what the deepest call here uses
constexpr std::size_t kPage = 4096;

/// Where memory is not locked, the pages of a stack come into being when they are first used: do it now.
[[gnu::noinline]] void touch_stack() noexcept {
  std::byte pages[kStackTouched];
  for (std::size_t at = 0; at < kStackTouched; at += kPage) pages[at] = std::byte{0};
  asm volatile("" : : "r"(pages) : "memory");  // as if they were read
}

std::string fifo_refusal(int error) {
  if (error == 0) return "";
  return std::string("SCHED_FIFO was refused (") + std::strerror(error) + ")";
}

std::string joined(const std::string& a, const std::string& b) {
  return a + (a.empty() || b.empty() ? "" : "; ") + b;
}

}  // namespace

RealTimePermission real_time_permission(SchedulerCalls& calls) {
  RealTimePermission permission;
  int error = 0;
  // The most urgent is what a limit refuses first.
  std::thread([&] { error = calls.set_fifo(fifo_priority(ThreadRole::Camera)); }).join();
  permission.fifo_refusal = fifo_refusal(error);
  if (const auto limit = calls.memory_lock_limit()) {
    // With a limit, an allocation in the middle of the run would fail that otherwise succeeds.
    permission.lock_refusal = "memory is not locked: the limit is " + std::to_string(*limit >> 10) + " KiB";
  }
  return permission;
}

RealTime::RealTime(RealTimeOptions options, std::shared_ptr<SchedulerCalls> calls)
    : options_(std::move(options)), calls_(std::move(calls)) {
  const std::vector<unsigned> usable = calls_->usable_cpus();
  for (const unsigned cpu : options_.cpus) {
    if (std::binary_search(usable.begin(), usable.end(), cpu)) continue;
    throw UsageError("--pin: CPU " + std::to_string(cpu) +
                     " is not there, or not for this process; it may use " + cpu_list_text(usable));
  }
  if (options_.mode == RealTimeMode::Off) return;
  permission_ = real_time_permission(*calls_);
  refuse(joined(permission_.fifo_refusal, permission_.lock_refusal));
}

/// Notes what is not to be had, or ends the run for it.
void RealTime::refuse(const std::string& what) {
  if (what.empty()) return;
  refusal_ = joined(refusal_, what);
  if (options_.mode == RealTimeMode::Require)
    throw Error("--realtime=require: " + refusal_ + "; " + std::string(kLimitsAdvice));
}

void RealTime::lock_memory() {
  if (options_.mode == RealTimeMode::Off || !permission_.lock_refusal.empty()) return;
  const int error = calls_->lock_memory();
  memory_locked_ = error == 0;
  if (error != 0) refuse(std::string("memory is not locked: ") + std::strerror(error));
}

void RealTime::enter(ThreadRole role) noexcept {
  const auto n = static_cast<std::size_t>(role);
  threads_[n].fetch_add(1, std::memory_order_relaxed);
  if (!options_.cpus.empty() && calls_->pin(options_.cpus) == 0)
    pinned_[n].fetch_add(1, std::memory_order_relaxed);
  if (options_.mode == RealTimeMode::Off) return;
  touch_stack();
  if (permission_.fifo_refusal.empty() && calls_->set_fifo(fifo_priority(role)) == 0)
    fifo_[n].fetch_add(1, std::memory_order_relaxed);
}

RealTimeState RealTime::state() const {
  RealTimeState state;
  state.mode = options_.mode;
  for (std::size_t n = 0; n < kThreadRoles; ++n) {
    state.threads[n] = threads_[n].load(std::memory_order_relaxed);
    state.fifo[n] = fifo_[n].load(std::memory_order_relaxed);
    state.pinned[n] = pinned_[n].load(std::memory_order_relaxed);
  }
  state.memory_locked = memory_locked_;
  state.cpus = options_.cpus;
  state.refusal = refusal_;
  return state;
}

std::string text_of(const RealTimeState& state) {
  std::string fifo, not_fifo, pinned;
  for (std::size_t n = 0; n < kThreadRoles; ++n) {
    if (state.threads[n] == 0) continue;
    const ThreadRole role{static_cast<std::uint8_t>(n)};
    const std::string name(name_of(role));
    if (state.fifo[n] == state.threads[n]) {
      fifo += (fifo.empty() ? "SCHED_FIFO " : ", ") + std::to_string(fifo_priority(role)) + " " + name;
    } else {
      not_fifo += (not_fifo.empty() ? "" : ", ") + name;
    }
    if (state.pinned[n] < state.threads[n]) pinned += (pinned.empty() ? "; not pinned: " : ", ") + name;
  }
  std::string text = fifo;
  if (state.mode == RealTimeMode::Off) {
    text = "off";
  } else {
    if (!not_fifo.empty()) text = joined(text, "usual scheduling of " + not_fifo);
    text = joined(text, state.memory_locked ? "memory locked" : "memory not locked");
  }
  if (state.cpus.empty()) return text;
  return joined(text, "on CPUs " + cpu_list_text(state.cpus) + pinned);
}

std::string_view name_of(RealTimeMode mode) noexcept {
  switch (mode) {
    case RealTimeMode::Off:
      return "off";
    case RealTimeMode::Auto:
      return "auto";
    case RealTimeMode::Require:
      break;
  }
  return "require";
}

std::string_view name_of(ThreadRole role) noexcept {
  switch (role) {
    case ThreadRole::Camera:
      return "cameras";
    case ThreadRole::Assembly:
      return "frame sets";
    case ThreadRole::Tracking:
      break;
  }
  return "tracking";
}

}  // namespace glint
