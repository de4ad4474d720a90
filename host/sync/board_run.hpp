// SPDX-License-Identifier: MIT
// The sync board as part of a run: starts it, listens to it, stops it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <thread>

#include "host/assemble/pulse_source.hpp"
#include "host/base/ring.hpp"
#include "usb-sync/board_link.hpp"

namespace glint {

struct BoardRunOptions {
  std::string serial;  ///< "": the only board there is
  /// What to start; of a board that is followed: where its light is. The board decides its strobes' polarity.
  sync::BoardPlan plan;
  bool follow = false;  ///< somebody else starts and stops the board
  sync::LinkOptions link;
  std::function<void(const std::string&)> on_event;  ///< one line of text; from the board's thread
};

/// What a run had of its board.
struct BoardCounters {
  std::uint64_t pulses = 0;     ///< told of
  std::uint64_t not_told = 0;   ///< fired, but the report was lost for good
  std::uint64_t not_taken = 0;  ///< told of, but the reader was too slow
  std::uint64_t gone = 0;       ///< how often it was unplugged, or hung
  std::uint64_t resets = 0;
  std::uint64_t lockouts = 0;  ///< how often its supply was too high for the lights
  double worst_error_s = 0.0;  ///< of FiredPulse::error_s, after the first second
};

/// Owns the link and the thread that serves it. A board that was reset, or that gave its host up, is started
/// again; the count of its pulses begins anew then.
class BoardRun final : public PulseSource {
 public:
  /// Opens the board. Throws sync::Error.
  explicit BoardRun(const BoardRunOptions& options, sync::HidBus& bus = sync::machine_hid_bus());
  ~BoardRun() override;

  /// Starts the board's run and listens. Throws sync::Error: the board refuses the plan, or is gone.
  void begin() override;
  /// Stops it, unless it is followed.
  void end() noexcept override;
  [[nodiscard]] bool take(FiredPulse& pulse) noexcept override { return ring_.pop(pulse); }

  const sync::Info& info() const noexcept { return info_; }
  BoardCounters counters() const noexcept;

 private:
  void start_board();
  void stop_board() noexcept;
  void listen(const std::stop_token& stop) noexcept;
  void on_trigger(const sync::TimedTrigger& timed) noexcept;
  void on_event(const sync::TimedEvent& timed) noexcept;
  void on_back(bool was_reset) noexcept;
  void restart() noexcept;
  void say(const std::string& text) const noexcept;

  BoardRunOptions options_;
  sync::BoardLink link_;
  sync::Info info_;
  sync::Seconds light_delay_{0.0};
  std::uint8_t strobes_ = 0;          // mask of those that the plan uses
  std::optional<std::uint16_t> run_;  // whose triggers count; none: of any
  std::uint64_t expected_ = 0;        // next sequence
  bool counting_ = false;             // expected_ is known
  bool restart_ = false;              // as soon as the board is there
  Ring<FiredPulse> ring_;
  std::atomic<std::uint64_t> pulses_{0}, not_told_{0}, not_taken_{0}, gone_{0}, resets_{0}, lockouts_{0};
  std::atomic<double> worst_error_s_{0.0};
  std::jthread thread_;  // last: it uses everything above
};

}  // namespace glint
