// SPDX-License-Identifier: MIT
// The board's own logic at the end of a cable of memory: in real time, with the kernel's queue of reports,
// and with what can go wrong in between.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "firmware/core/sync_device.hpp"
#include "tests/unit/firmware/test_bench.hpp"
#include "usb-sync/hid_port.hpp"

namespace glint::sync {

class PluggedBoard {
 public:
  using Bytes = std::vector<std::uint8_t>;

  explicit PluggedBoard(std::uint8_t serial = 8) : serial_{0xe6, 0x60, 0, 0, 0, 0, 0, serial} { boot(); }

  void unplug() noexcept {
    const std::lock_guard lock(mutex_);
    ++plug_;
    present = false;
  }
  void plug() {
    const std::lock_guard lock(mutex_);
    boot();
    present = true;
  }
  /// As the watchdog does: gone from the bus, and back with a new epoch.
  void reset() {
    const std::lock_guard lock(mutex_);
    ++plug_;
    boot();
  }
  /// The cable loses contact for a moment; the board has other power and goes on.
  void reconnect() noexcept {
    const std::lock_guard lock(mutex_);
    ++plug_;
    queue_.clear();
  }
  /// The host resets the bus: a run that needs its host ends.
  void reset_bus() {
    const std::lock_guard lock(mutex_);
    run_to_now();
    device_->on_bus_lost(now_);
  }
  /// Its counter begins anew, and the bus does not notice.
  void reset_unnoticed() {
    const std::lock_guard lock(mutex_);
    boot();
  }

  /// As if it had come from the board by itself.
  void inject(Bytes bytes) {
    const std::lock_guard lock(mutex_);
    queue_.push_back(std::move(bytes));
  }
  /// Rises and falls again, at once.
  void edge_at_sync_in();

  FoundBoard found() const { return {"/dev/hidraw" + std::to_string(serial_[7]), serial_text()}; }
  std::string serial_text() const;
  std::uint32_t epoch() const noexcept { return epoch_; }
  std::size_t queued() const noexcept { return queue_.size(); }

  std::atomic<bool> present = true;
  bool permitted = true;
  bool strobes_active_low = false;
  std::uint8_t protocol = GLINT_SYNC_PROTOCOL_MAJOR;  ///< what it says that it speaks
  std::atomic<std::uint16_t> supply_mv = 12'000;
  std::size_t lose_next = 0;  ///< so many reports do not reach the program
  bool forgets = false;       ///< FETCH gives nothing back
  std::size_t fetches = 0, queries = 0;
  int measured_wire = -1;  ///< output wired to sync in

 private:
  friend class PluggedPort;
  void boot();
  void run_to_now();
  std::uint64_t tick_of_now() const;
  int read(std::span<std::uint8_t> into, std::chrono::milliseconds longest);
  int get(std::span<std::uint8_t> report);
  bool set(std::span<const std::uint8_t> report);

  std::array<std::uint8_t, 8> serial_;
  std::uint32_t epoch_ = 100;
  std::recursive_mutex mutex_;  // a test may do to the board what it likes while a thread talks to it
  std::atomic<std::uint64_t> plug_ = 0;  // connections made before the last change are dead
  std::chrono::steady_clock::time_point powered_;
  std::uint64_t now_ = 0, next_sample_ = 0;
  std::optional<board::NotedPulses> pulses_;
  std::unique_ptr<board::SyncDevice> device_;
  std::deque<Bytes> queue_;
};

/// Boards by reference: they outlive it.
class PluggedBus final : public HidBus {
 public:
  explicit PluggedBus(std::vector<PluggedBoard*> boards) : boards_(std::move(boards)) {}
  std::vector<FoundBoard> boards() override;
  std::unique_ptr<HidPort> open(const FoundBoard& board) override;

 private:
  std::vector<PluggedBoard*> boards_;
};

}  // namespace glint::sync
