// SPDX-License-Identifier: MIT
// Frames of several triggered cameras as a driver would deliver them, with faults of which everything is
// known.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <random>
#include <vector>

#include "host/assemble/assembler.hpp"

namespace glint::testing {

struct RigFaults {
  double never_sent = 0.0, lost_by_host = 0.0, twice = 0.0, late = 0.0,
         corrupt = 0.0;  // probabilities per frame
};

struct RigOptions {
  std::size_t cameras = 4;
  double rate_hz = 90.0;
  double crystal_ppm = 0.0;  ///< how much longer the true period is
  double jitter_s = 0.0;     ///< of a stamp, standard deviation, Gaussian
  double quantum_s = 0.0;    ///< stamps and arrivals only at multiples of it, a phase for each camera; 0: any
  std::vector<double> offset_s;  ///< stamp minus pulse; empty: 0
  double latency_s = 0.002;      ///< arrival minus stamp; may be negative
  double origin_s = 1000.0;      ///< of the first pulse on the clock
  std::uint32_t first_sequence = 0;
  std::int64_t pulses = 1000;
  RigFaults faults;
  /// A camera is away from one pulse to before another, and then starts a new stream.
  struct Away {
    std::size_t camera = 0;
    std::int64_t from = 0, to = 0;
  };
  std::vector<Away> away;
  /// From a pulse on a camera's frames show the exposure so many pulses earlier (later if negative). Earlier:
  /// for `silent` pulses it sends nothing first. Later: first it sends so many frames more within one pulse.
  struct Slip {
    std::size_t camera = 0;
    std::int64_t from = 0;
    int pulses = 0, silent = 1;
  };
  std::optional<Slip> slip;
  std::uint64_t seed = 1;
};

/// One frame on its way, or (`left`) the news that a camera is gone.
struct Delivery {
  std::size_t camera = 0;
  std::int64_t pulse = 0;
  std::int64_t shown = 0;  ///< exposure that it shows; the pulse, unless the camera has slipped
  std::uint32_t sequence = 0;
  double stamped_s = 0.0, arrived_s = 0.0;
  bool damaged = false, second = false, left = false;
};

struct SimulatedRig {
  explicit SimulatedRig(const RigOptions& options);

  RigOptions options;
  double period_s = 0.0;
  std::vector<Delivery> deliveries;           ///< in order of arrival
  std::vector<std::vector<FrameFate>> truth;  ///< [pulse][camera]; Used: whole and in time

  double pulse_s(std::int64_t pulse) const {
    return options.origin_s + static_cast<double>(pulse) * period_s;
  }
};

Timestamp at(double seconds);

/// Feeds an assembler from a rig and compares what comes out with the truth. Pixels carry the true pulse.
class RigRun {
 public:
  RigRun(const SimulatedRig& rig, const AssembleOptions& options, double work_s = 0.0);

  /// All deliveries, then time for the last sets.
  void run();
  /// Up to the delivery that is given.
  void run_until(std::size_t delivery);
  void deliver(const Delivery& delivery);
  /// Lets time pass; sets are taken as soon as they are due and the consumer has finished with the last one.
  void pass_until(double time_s);

  Assembler& assembler() { return assembler_; }
  /// What the ledger should be, from the first pulse counted to the last.
  CameraLedger expected(std::size_t camera) const;

  std::uint64_t sets = 0, frames = 0, mispaired = 0, unbalanced = 0, not_in_order = 0, damaged = 0;
  std::uint64_t second_frames = 0, not_aligned = 0, outside_error = 0;
  double oldest_s = 0.0;  ///< greatest age of a set when it was taken, since its last stamp was due to arrive
  double most_time_error_s = 0.0;     ///< of FrameSet::exposed against the pulse
  std::optional<std::int64_t> first;  ///< true pulse that the assembler calls 0

 private:
  void take(FrameSet& set);

  const SimulatedRig& rig_;
  FramePool pool_;
  Assembler assembler_;
  double work_s_, clock_s_, busy_until_s_;
  std::size_t delivered_ = 0;
  std::optional<std::uint64_t> last_trigger_;
  std::optional<Timestamp> last_exposed_;
};

}  // namespace glint::testing
