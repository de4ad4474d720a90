// SPDX-License-Identifier: MIT
// A sync board of logic and time alone: outputs that note their pulses, a supply, a host.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <vector>

#include "firmware/core/sync_device.hpp"

namespace glint::board {

/// A pulse that left an output, in ticks.
struct Pulse {
  std::uint64_t rise, fall;
  std::uint64_t width() const { return fall - rise; }
};

/// Works off segments as the pulse program does, to the tick.
class NotedPulses final : public PulseHardware {
 public:
  explicit NotedPulses(const std::uint64_t& now) : now_(now) {}

  void prepare(const Setup& setup) override;
  void feed(unsigned output, std::uint32_t low, std::uint32_t width) override;
  unsigned waiting_words(unsigned output) const override;
  bool ran_dry() const override { return ran_dry_; }
  std::uint64_t open_gate() override;
  bool arm(bool& missed) override;
  bool disarm() override {
    armed_ = false;
    return false;
  }
  void halt() override;
  void hold_strobes(bool hold) override;
  bool take_measured(std::uint32_t& low, std::uint32_t& width) override;
  std::uint32_t measure_resolution() const override { return 2; }

  /// An edge at sync in, now; false if nobody waits for it.
  bool edge();
  /// Pulses that have left the output wholly or in part until now.
  std::vector<Pulse> pulses(unsigned output) const;
  void forget_pulses();

  bool stuck = false;         ///< outputs begin nothing any more
  bool sync_in_high = false;  ///< arming has to wait
  int measured_wire = -1;     ///< output wired to sync in
  std::optional<Setup> setup;

 private:
  struct Segment {
    std::uint64_t begin, low_from;
    std::uint32_t low, width;
    bool placed;
  };
  struct Output {
    std::uint64_t end = 0;
    std::deque<Segment> fed;
    std::vector<Pulse> pulses;
  };
  void cut(Output& output, bool strobe);

  const std::uint64_t& now_;
  std::array<Output, GLINT_SYNC_OUTPUTS> outputs_;
  std::uint64_t gate_ = 0;
  bool open_ = false, armed_ = false, missed_ = false, ran_dry_ = false;
  bool held_ = false;
  std::uint64_t held_since_ = 0;
  std::size_t measured_ = 0;
};

class TestBench {
 public:
  explicit TestBench(bool strobes_active_low = false, std::uint8_t reset_reason = GLINT_SYNC_RESET_POWER);

  /// Lets time go on; the supply is sampled as on the board, timers come up to `timer_delay` late.
  void run_until(std::uint64_t tick);
  void run_us(std::uint64_t us) { run_until(now + us * 125); }

  template <class Report>
  bool set(std::uint8_t id, Report report) {
    report.report_id = id;
    report.protocol = GLINT_SYNC_PROTOCOL_MAJOR;
    return set_bytes(&report, sizeof report);
  }
  bool set_bytes(const void* bytes, std::size_t size);
  template <class Report>
  Report get(std::uint8_t id) {
    Report report{};
    got = device.get_report(id, reinterpret_cast<std::uint8_t*>(&report), now, now);
    return report;
  }
  glint_sync_status status() { return get<glint_sync_status>(GLINT_SYNC_STATUS); }
  bool locked() { return (status().flags & GLINT_SYNC_FLAG_LOCKED) != 0; }
  bool command(std::uint8_t code, std::uint32_t argument = 0);
  bool start() { return command(GLINT_SYNC_COMMAND_START); }
  bool edge();

  /// Stages a period, and an output.
  void stage_period_us(std::uint32_t us, std::uint8_t flags = 0, std::uint32_t pulses = 0);
  void stage_output(unsigned output, std::uint32_t delay_us, std::uint32_t width_us, std::uint8_t every_n = 1,
                    std::uint8_t phase = 0);

  std::vector<glint_sync_input> take_reports();
  /// Of the triggers in those reports, in order.
  struct Trigger {
    std::uint64_t tick;
    std::uint32_t sequence;
    std::uint8_t outputs, flags;
  };
  static std::vector<Trigger> triggers_in(const std::vector<glint_sync_input>& reports);

  std::uint64_t now = 1000;
  std::uint32_t timer_delay = 0;
  std::uint16_t supply_mv = 12000;
  bool supply_measured = true;
  bool got = false;
  Request request = Request::None;
  NotedPulses hardware;
  SyncDevice device;

 private:
  std::uint64_t next_sample_;
};

}  // namespace glint::board
