// SPDX-License-Identifier: MIT
// Watching the sync board: figures of the last second and of all the time, and what happens in between.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "host/output/latency_histogram.hpp"
#include "usb-sync/board_link.hpp"

namespace glint::apps {

/// p50, p99 and the greatest of the reports' delays: from what a report tells to its arrival.
struct DelayFigures {
  std::uint64_t count = 0;
  double p50_s = 0.0, p99_s = 0.0, max_s = 0.0;
};

/// Frames since the watch began.
struct FrameCounters {
  std::uint64_t seen = 0;
  std::uint64_t missing = 0;  ///< gaps between those seen, within a run
  std::uint64_t dark = 0;     ///< of those seen: left dark by the code
  std::uint64_t locked = 0;   ///< strobes were held off, because the supply was too high
  std::uint64_t held = 0;     ///< a strobe was left out by the firmware
};

/// Counts triggers and delays, of the time since the last window and of all.
class WatchStatistics {
 public:
  struct Window {
    std::uint64_t frames = 0;
    std::optional<double> rate_hz;  ///< on the board's clock; nothing without two frames of the newest run
    DelayFigures delay;
  };

  void add(const sync::TimedTrigger& trigger) noexcept;
  /// Of a report that came by itself.
  void add_delay(double seconds) noexcept;

  /// What came since the last call.
  Window take_window(std::uint32_t tick_hz);
  const FrameCounters& frames() const noexcept { return frames_; }
  DelayFigures all_delays() const;

 private:
  struct Mark {
    std::uint32_t epoch = 0;
    std::uint16_t run = 0;
    std::uint64_t sequence = 0, tick = 0;
  };

  FrameCounters frames_;
  std::uint64_t window_frames_ = 0;
  std::optional<Mark> from_, last_;  // the rate is that between them
  LatencyHistogram window_delays_, all_delays_;
};

/// What the live line says.
struct WatchUpdate {
  double since_start_s = 0.0;
  bool present = true;  ///< the board answers; what follows is as it was last, if not
  std::string trouble;  ///< why the board cannot be opened again; "" if it is just not there
  sync::RunState state = sync::RunState::Idle;
  int run = 0;
  std::uint8_t fault = 0;  ///< glint_sync_fault
  bool supply_locked = false;
  double supply_v = 0.0;
  WatchStatistics::Window window;
  sync::LinkCounters counters;
  std::optional<double> clock_bound_s;  ///< of the error of host times
};

/// Something that happened.
struct WatchEvent {
  double since_start_s = 0.0;
  std::string kind;  ///< a key: "stopped"
  std::string text;
  std::optional<int> run;
  std::optional<std::uint64_t> frame;      ///< as kind says: first, or number of them
  std::optional<sync::HostInterval> when;  ///< on the host's clock, where the board said it
};

struct WatchSummary {
  double seconds = 0.0;
  FrameCounters frames;
  DelayFigures delay;
  sync::LinkCounters counters;
  double least_supply_v = 0.0, most_supply_v = 0.0;
  std::uint64_t clock_restarts = 0;
};

/// Where it goes. May throw, which ends the watch.
class WatchSink {
 public:
  virtual ~WatchSink() = default;
  virtual void begin(const sync::Info& info) = 0;
  virtual void event(const WatchEvent& event) = 0;
  virtual void update(const WatchUpdate& update) = 0;
  virtual void end(const WatchSummary& summary) = 0;
};

/// What an event of the board means: kind, text, run, frame; since_start_s is left to the caller.
WatchEvent event_of(const sync::TimedEvent& event);

struct WatchOptions {
  std::chrono::milliseconds update_period{1000};
  std::optional<double> seconds;  ///< nothing: until `stop`
};

/// Until `stop` is set or the time is over. A board that goes away is waited for.
void watch(sync::BoardLink& link, WatchSink& sink, const WatchOptions& options,
           const std::atomic<bool>& stop);

}  // namespace glint::apps
