// SPDX-License-Identifier: MIT
// Draws the faults, sorts by arrival, feeds and compares.
#include "tests/unit/assemble/simulated_rig.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace glint::testing {
namespace {

constexpr std::int64_t kCleanAtEnd = 10;  // pulses without faults, so that every gap is seen

bool untouched(const RigOptions& options, std::size_t camera, std::int64_t pulse) {
  if (pulse >= options.pulses - kCleanAtEnd) return true;
  // A gap before a new stream cannot be told.
  for (const RigOptions::Away& away : options.away) {
    if (away.camera == camera && pulse >= away.from - 3 && pulse < away.to + 3) return true;
  }
  return false;
}

bool is_away(const RigOptions& options, std::size_t camera, std::int64_t pulse) {
  return std::any_of(options.away.begin(), options.away.end(), [&](const RigOptions::Away& away) {
    return away.camera == camera && pulse >= away.from && pulse < away.to;
  });
}

enum class Fault { None, NeverSent, LostByHost, Twice, Late, Corrupt };

}  // namespace

Timestamp at(double seconds) {
  return Timestamp(std::chrono::nanoseconds(static_cast<std::int64_t>(std::llround(seconds * 1e9))));
}

SimulatedRig::SimulatedRig(const RigOptions& given)
    : options(given), period_s((1.0 + given.crystal_ppm * 1e-6) / given.rate_hz) {
  std::mt19937_64 random(options.seed);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::normal_distribution<double> normal;
  options.offset_s.resize(options.cameras, 0.0);
  std::vector<double> quantum_phase(options.cameras);
  for (double& phase : quantum_phase) phase = unit(random) * options.quantum_s;
  std::vector<std::uint32_t> sequence(options.cameras, options.first_sequence);
  truth.assign(static_cast<std::size_t>(options.pulses),
               std::vector<FrameFate>(options.cameras, FrameFate::Used));
  deliveries.reserve(static_cast<std::size_t>(options.pulses) * options.cameras * 11 / 10);
  std::vector<Fault> faults(options.cameras);

  for (std::int64_t pulse = 0; pulse < options.pulses; ++pulse) {
    for (std::size_t camera = 0; camera < options.cameras; ++camera) {
      const RigFaults& f = options.faults;
      double draw = unit(random);
      const auto drawn = [&draw](double probability) {
        draw -= probability;
        return draw < 0.0;
      };
      faults[camera] = untouched(options, camera, pulse) ? Fault::None
                       : drawn(f.never_sent)             ? Fault::NeverSent
                       : drawn(f.lost_by_host)           ? Fault::LostByHost
                       : drawn(f.twice)                  ? Fault::Twice
                       : drawn(f.late)                   ? Fault::Late
                       : drawn(f.corrupt)                ? Fault::Corrupt
                                                         : Fault::None;
    }
    // A frame is late only if another one made its set wait.
    bool in_time = false;
    for (std::size_t camera = 0; camera < options.cameras; ++camera) {
      in_time = in_time || (faults[camera] == Fault::None && !is_away(options, camera, pulse));
    }
    for (std::size_t camera = 0; camera < options.cameras; ++camera) {
      FrameFate& fate = truth[static_cast<std::size_t>(pulse)][camera];
      if (is_away(options, camera, pulse)) {
        fate = FrameFate::LostByCamera;
        sequence[camera] = 0;
        continue;
      }
      Fault fault = faults[camera];
      const bool slipped = options.slip && options.slip->camera == camera && pulse >= options.slip->from;
      if (slipped && options.slip->pulses > 0 && pulse < options.slip->from + options.slip->silent) {
        fault = Fault::NeverSent;
      }
      const bool flushes = slipped && pulse == options.slip->from && options.slip->pulses < 0;
      if (flushes) fault = Fault::None;
      if (fault == Fault::Late && !in_time) fault = Fault::None;
      if (fault == Fault::NeverSent) {
        fate = FrameFate::LostByCamera;
        continue;
      }
      if (fault == Fault::LostByHost) {
        fate = FrameFate::LostByHost;
        ++sequence[camera];
        continue;
      }
      Delivery d;
      d.camera = camera;
      d.pulse = pulse;
      d.shown = slipped && !flushes ? pulse - options.slip->pulses : pulse;
      const auto stamp = [&](double extra) {
        double stamped =
            pulse_s(pulse) + options.offset_s[camera] + extra + options.jitter_s * normal(random);
        if (options.quantum_s > 0.0) {
          stamped = quantum_phase[camera] +
                    options.quantum_s * std::ceil((stamped - quantum_phase[camera]) / options.quantum_s);
        }
        d.stamped_s = stamped;
        d.arrived_s = stamped + options.latency_s;
        d.sequence = sequence[camera]++;
      };
      stamp(0.0);
      if (fault == Fault::Late) {
        fate = FrameFate::Late;
        d.arrived_s = pulse_s(pulse) + options.offset_s[camera] + options.latency_s + options.quantum_s +
                      (0.8 + 2.2 * unit(random)) * period_s;
      }
      if (fault == Fault::Corrupt) {
        fate = FrameFate::Corrupt;
        d.damaged = true;
      }
      deliveries.push_back(d);
      for (int extra = 1; flushes && extra <= -options.slip->pulses; ++extra) {
        Delivery more = d;
        more.second = true;
        more.shown = pulse + extra;
        more.sequence = sequence[camera]++;
        more.stamped_s += 0.02 * period_s * extra;
        more.arrived_s += 0.02 * period_s * extra;
        deliveries.push_back(more);
      }
      if (fault == Fault::Twice) {
        const double first_arrived = d.arrived_s;
        stamp(0.1 * unit(random) * period_s);
        d.second = true;
        d.arrived_s = std::max(d.arrived_s, first_arrived + 1e-6);
        deliveries.push_back(d);
      }
    }
  }
  for (const RigOptions::Away& away : options.away) {
    Delivery d;
    d.camera = away.camera;
    d.left = true;
    d.arrived_s = pulse_s(away.from + 3);
    deliveries.push_back(d);
  }
  std::stable_sort(deliveries.begin(), deliveries.end(),
                   [](const Delivery& a, const Delivery& b) { return a.arrived_s < b.arrived_s; });
}

RigRun::RigRun(const SimulatedRig& rig, const AssembleOptions& options, double work_s)
    : rig_(rig),
      pool_(std::vector<FrameSize>(rig.options.cameras, FrameSize{16, 8}), 64),
      assembler_(rig.options.cameras, options),
      work_s_(work_s),
      clock_s_(rig.options.origin_s - 1.0),
      busy_until_s_(clock_s_) {}

void RigRun::take(FrameSet& set) {
  ++sets;
  const std::uint64_t trigger = number(set.trigger);
  if (last_trigger_ && trigger <= *last_trigger_) ++not_in_order;
  if (last_exposed_ && set.exposed <= *last_exposed_) ++not_in_order;
  last_trigger_ = trigger;
  last_exposed_ = set.exposed;
  if (!assembler_.aligned()) ++not_aligned;
  std::optional<std::int64_t> pulse;
  for (std::size_t camera = 0; camera < rig_.options.cameras; ++camera) {
    if (!set.frames[camera]) continue;
    ++frames;
    Delivery tag;
    std::memcpy(&tag, set.frames[camera]->pixels().data(), sizeof tag);
    if (tag.camera != camera) ++mispaired;
    if (tag.damaged) ++damaged;
    if (tag.second) ++second_frames;
    if (!first) first = tag.pulse - static_cast<std::int64_t>(trigger);
    if (tag.pulse != static_cast<std::int64_t>(trigger) + *first) ++mispaired;
    pulse = tag.pulse;
  }
  if (!pulse) {
    ADD_FAILURE() << "a set without frames";
    return;
  }
  const double error = seconds_between(at(rig_.pulse_s(*pulse)), set.exposed);
  most_time_error_s = std::max(most_time_error_s, std::abs(error));
  if (std::abs(error) > assembler_.exposed_error_s()) ++outside_error;
  oldest_s = std::max(oldest_s, clock_s_ - rig_.pulse_s(*pulse) - rig_.options.latency_s);
  busy_until_s_ = clock_s_ + work_s_;
}

void RigRun::pass_until(double time_s) {
  FrameSet set;
  for (;;) {
    if (busy_until_s_ > clock_s_) {
      if (busy_until_s_ > time_s) break;
      clock_s_ = busy_until_s_;
    }
    const bool taken = assembler_.next(set, at(clock_s_));
    if (!assembler_.ledger().balanced()) ++unbalanced;
    if (taken) {
      take(set);
      continue;
    }
    const std::optional<Timestamp> due = assembler_.due();
    if (!due || *due > at(time_s)) break;
    const double due_s = std::chrono::duration<double>(due->time_since_epoch()).count();
    if (due_s + 1e-6 <= clock_s_) {
      ADD_FAILURE() << "due() is in the past, and next() gives nothing";
      break;
    }
    clock_s_ = std::max(clock_s_, due_s + 1e-6);
  }
  clock_s_ = std::max(clock_s_, time_s);
}

void RigRun::deliver(const Delivery& delivery) {
  pass_until(delivery.arrived_s);
  const CameraId camera{static_cast<std::uint8_t>(delivery.camera)};
  if (delivery.left) {
    assembler_.set_present(camera, false);
    return;
  }
  std::optional<Frame> frame = pool_.take(camera);
  ASSERT_TRUE(frame) << "frames were not given back";
  std::memcpy(frame->pixels().data(), &delivery, sizeof delivery);
  frame->sequence = delivery.sequence;
  frame->stamped = at(delivery.stamped_s);
  frame->stamp = StampPoint::StartOfExposure;
  frame->damaged = delivery.damaged;
  assembler_.add(std::move(*frame), at(delivery.arrived_s));
  if (!assembler_.ledger().balanced()) ++unbalanced;
}

void RigRun::run_until(std::size_t delivery) {
  for (; delivered_ < delivery; ++delivered_) deliver(rig_.deliveries[delivered_]);
}

void RigRun::run() {
  run_until(rig_.deliveries.size());
  pass_until(clock_s_ + 1.0);
}

CameraLedger RigRun::expected(std::size_t camera) const {
  CameraLedger ledger;
  if (!first) return ledger;
  const std::int64_t end = *first + static_cast<std::int64_t>(assembler_.ledger().pulses);
  for (std::int64_t pulse = *first; pulse < end; ++pulse) {
    ++ledger[rig_.truth[static_cast<std::size_t>(pulse)][camera]];
  }
  for (const Delivery& delivery : rig_.deliveries) {
    if (delivery.second && delivery.camera == camera && delivery.pulse >= *first) ++ledger.duplicates;
  }
  return ledger;
}

}  // namespace glint::testing
