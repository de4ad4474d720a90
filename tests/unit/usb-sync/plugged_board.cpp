// SPDX-License-Identifier: MIT
#include "tests/unit/usb-sync/plugged_board.hpp"

#include <algorithm>
#include <thread>

#include "firmware/core/supply_monitor.hpp"
#include "usb-sync/error.hpp"

namespace glint::sync {

constexpr std::size_t kKernelQueue = 63;  // HIDRAW_BUFFER_SIZE less one; the newest is dropped

class PluggedPort final : public HidPort {
 public:
  explicit PluggedPort(PluggedBoard& board) : board_(board), plug_(board.plug_) {}

  int read(std::span<std::uint8_t> into, std::chrono::milliseconds longest) noexcept override {
    return plugged() ? board_.read(into, longest) : -1;
  }
  int get_feature(std::span<std::uint8_t> report) noexcept override {
    return plugged() ? board_.get(report) : -1;
  }
  bool set_feature(std::span<const std::uint8_t> report) noexcept override {
    return plugged() && board_.set(report);
  }

 private:
  bool plugged() const noexcept { return board_.present && plug_ == board_.plug_; }

  PluggedBoard& board_;
  std::uint64_t plug_;
};

std::string PluggedBoard::serial_text() const {
  std::string text;
  for (const std::uint8_t byte : serial_) {
    text += "0123456789ABCDEF"[byte >> 4];
    text += "0123456789ABCDEF"[byte & 15];
  }
  return text;
}

void PluggedBoard::boot() {
  queue_.clear();
  powered_ = std::chrono::steady_clock::now();
  now_ = next_sample_ = tick_of_now();
  pulses_.emplace(now_);
  board::Identity identity{{}, ++epoch_, GLINT_SYNC_RESET_POWER, strobes_active_low, 0x000203, "abcdef0123"};
  std::copy(serial_.begin(), serial_.end(), identity.serial);
  device_ = std::make_unique<board::SyncDevice>(*pulses_, identity, now_);
}

std::uint64_t PluggedBoard::tick_of_now() const {
  constexpr std::uint64_t kUntilReady = 125'000'000;  // strobes have to wait after power-up
  const std::chrono::nanoseconds on = std::chrono::steady_clock::now() - powered_;
  return kUntilReady + static_cast<std::uint64_t>(on.count()) / 8;
}

void PluggedBoard::run_to_now() {
  const std::uint64_t until = tick_of_now();
  pulses_->measured_wire = measured_wire;
  while (true) {
    const std::uint64_t next = std::min(device_->next_due(), next_sample_);
    if (next > until) break;
    now_ = std::max(now_, next);
    if (next == next_sample_) {
      next_sample_ += board::kTickHz / board::SupplyMonitor::kSampleHz;
      device_->on_supply(supply_mv, now_);
    } else {
      device_->on_timer(now_);
    }
    while (const glint_sync_input* report = device_->take_report()) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(report);
      if (lose_next > 0) {
        --lose_next;
      } else if (queue_.size() < kKernelQueue) {
        queue_.emplace_back(bytes, bytes + sizeof *report);
      }
    }
  }
  now_ = std::max(now_, until);
}

void PluggedBoard::edge_at_sync_in() {
  const std::lock_guard lock(mutex_);
  run_to_now();
  if (pulses_->edge()) device_->on_edge(now_);
}

int PluggedBoard::read(std::span<std::uint8_t> into, std::chrono::milliseconds longest) {
  const auto deadline = std::chrono::steady_clock::now() + longest;
  std::unique_lock lock(mutex_);
  while (true) {
    run_to_now();
    if (!queue_.empty()) break;
    if (std::chrono::steady_clock::now() >= deadline) return 0;
    lock.unlock();
    std::this_thread::sleep_for(std::chrono::microseconds(200));
    lock.lock();
  }
  const Bytes report = queue_.front();
  queue_.pop_front();
  std::copy_n(report.begin(), std::min(report.size(), into.size()), into.begin());
  return static_cast<int>(std::min(report.size(), into.size()));
}

int PluggedBoard::get(std::span<std::uint8_t> report) {
  const std::lock_guard lock(mutex_);
  run_to_now();
  if (report[0] == GLINT_SYNC_FETCH) ++fetches;
  if (report[0] == GLINT_SYNC_TIME) ++queries;
  if (!device_->get_report(report[0], report.data(), now_, now_)) return -1;
  report[1] = protocol;
  if (forgets && report[0] == GLINT_SYNC_FETCH) report[1] = 0;
  return static_cast<int>(report.size());
}

bool PluggedBoard::set(std::span<const std::uint8_t> report) {
  const std::lock_guard lock(mutex_);
  run_to_now();
  board::Request request = board::Request::None;
  const auto size = static_cast<std::uint32_t>(report.size());
  if (!device_->set_report(report.data(), size, now_, request)) return false;
  if (request == board::Request::Reset) reset();
  if (request == board::Request::Bootloader) unplug();
  return true;
}

std::vector<FoundBoard> PluggedBus::boards() {
  std::vector<FoundBoard> found;
  for (const PluggedBoard* board : boards_) {
    if (board->present) found.push_back(board->found());
  }
  return found;
}

std::unique_ptr<HidPort> PluggedBus::open(const FoundBoard& wanted) {
  for (PluggedBoard* board : boards_) {
    if (!board->present || board->found().path != wanted.path) continue;
    if (!board->permitted) throw Error("no permission to open " + wanted.path);
    return std::make_unique<PluggedPort>(*board);
  }
  throw Error(wanted.path + " is gone");
}

}  // namespace glint::sync
