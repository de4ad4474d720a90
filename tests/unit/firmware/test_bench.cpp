// SPDX-License-Identifier: MIT
#include "tests/unit/firmware/test_bench.hpp"

#include <algorithm>

namespace glint::board {
namespace {

constexpr std::uint32_t kSamplePeriod = kTickHz / SupplyMonitor::kSampleHz;
constexpr std::uint64_t kGateDelay = 3000;  // from the plan to the open gate

bool strobe(unsigned output) { return output >= GLINT_SYNC_TRIGGERS; }

}  // namespace

void NotedPulses::prepare(const Setup& with) {
  halt();
  setup = with;
  ran_dry_ = false;
  measured_ = with.measured < 0 ? 0 : pulses(static_cast<unsigned>(with.measured)).size();
}

void NotedPulses::feed(unsigned output, std::uint32_t low, std::uint32_t width) {
  Output& out = outputs_[output];
  if (setup->external || !open_) {
    out.fed.push_back({0, 0, low, width, false});
    return;
  }
  if (out.end < now_) ran_dry_ = true;
  const std::uint64_t from = std::max(out.end, now_);
  out.fed.push_back({from + low, from, low, width, true});
  out.end = from + low + width;
}

unsigned NotedPulses::waiting_words(unsigned output) const {
  unsigned words = 0;
  for (const Segment& segment : outputs_[output].fed) {
    if (stuck || !segment.placed || segment.low_from > now_)
      words += 2;
    else if (segment.begin > now_)
      words += 1;
  }
  return words;
}

std::uint64_t NotedPulses::open_gate() {
  gate_ = now_ + kGateDelay;
  open_ = true;
  for (Output& out : outputs_) {
    out.end = gate_;
    for (Segment& segment : out.fed) {
      segment = {out.end + segment.low, out.end, segment.low, segment.width, true};
      out.end = segment.begin + segment.width;
    }
  }
  return gate_;
}

bool NotedPulses::arm(bool& missed) {
  missed = missed_;
  missed_ = false;
  if (!sync_in_high) armed_ = true;
  return armed_;
}

bool NotedPulses::edge() {
  if (!armed_) {
    missed_ = true;
    return false;
  }
  armed_ = false;
  for (Output& out : outputs_)
    for (Segment& segment : out.fed)
      if (!segment.placed) {
        segment = {now_ + segment.low, now_, segment.low, segment.width, true};
        out.end = segment.begin + segment.width;
      }
  return true;
}

void NotedPulses::halt() {
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    Output& out = outputs_[i];
    for (const Segment& segment : out.fed)
      if (segment.placed && segment.width != 0 && segment.begin < now_)
        out.pulses.push_back({segment.begin, std::min(segment.begin + segment.width, now_)});
    out.fed.clear();
  }
  open_ = armed_ = missed_ = false;
}

/// Moves what has happened from the segments to the pulses; while strobes are held, theirs do not get out.
void NotedPulses::cut(Output& out, bool is_strobe) {
  while (!out.fed.empty() && out.fed.front().placed &&
         out.fed.front().begin + out.fed.front().width <= now_) {
    const Segment segment = out.fed.front();
    out.fed.pop_front();
    const std::uint64_t end = segment.begin + segment.width;
    if (segment.width == 0 || stuck) continue;
    if (!is_strobe || !held_ || end <= held_since_)
      out.pulses.push_back({segment.begin, end});
    else if (segment.begin < held_since_)
      out.pulses.push_back({segment.begin, held_since_});
  }
}

void NotedPulses::hold_strobes(bool hold) {
  for (unsigned i = GLINT_SYNC_TRIGGERS; i < GLINT_SYNC_OUTPUTS; ++i) {
    cut(outputs_[i], true);
    Output& out = outputs_[i];
    // Let go amid a pulse, its end would be a pulse of its own.
    if (!hold && held_ && !out.fed.empty() && out.fed.front().placed && out.fed.front().begin < now_)
      out.fed.front().begin = now_;
  }
  held_ = hold;
  held_since_ = now_;
}

std::vector<Pulse> NotedPulses::pulses(unsigned output) const {
  Output copy = outputs_[output];
  const_cast<NotedPulses*>(this)->cut(copy, strobe(output));
  return copy.pulses;
}

void NotedPulses::forget_pulses() {
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    cut(outputs_[i], strobe(i));
    outputs_[i].pulses.clear();
  }
}

bool NotedPulses::take_measured(std::uint32_t& low, std::uint32_t& width) {
  if (!setup || setup->measured < 0 || setup->measured != measured_wire) return false;
  const std::vector<Pulse> all = pulses(static_cast<unsigned>(measured_wire));
  if (measured_ >= all.size()) return false;
  low = measured_ == 0 ? 0 : static_cast<std::uint32_t>(all[measured_].rise - all[measured_ - 1].fall);
  width = static_cast<std::uint32_t>(all[measured_].width());
  ++measured_;
  return true;
}

TestBench::TestBench(bool strobes_active_low, std::uint8_t reset_reason)
    : hardware(now),
      device(hardware,
             Identity{{1, 2, 3, 4, 5, 6, 7, 8}, 0xabcd, reset_reason, strobes_active_low, 0x000100, "abcdef"},
             now),
      next_sample_(now) {
  run_us(20'000);  // so that strobes may fire
}

void TestBench::run_until(std::uint64_t tick) {
  for (;;) {
    const std::uint64_t due = device.next_due();
    const std::uint64_t timer = due == SyncDevice::kNever ? due : std::max(due + timer_delay, now);
    const std::uint64_t next = std::min(timer, next_sample_);
    if (next > tick) break;
    now = std::max(now, next);
    if (next == next_sample_) {
      next_sample_ += kSamplePeriod;
      if (supply_measured) device.on_supply(supply_mv, now);
    } else {
      device.on_timer(now);
    }
  }
  now = std::max(now, tick);
}

bool TestBench::set_bytes(const void* bytes, std::size_t size) {
  return device.set_report(static_cast<const std::uint8_t*>(bytes), static_cast<std::uint32_t>(size), now,
                           request);
}

bool TestBench::command(std::uint8_t code, std::uint32_t argument) {
  glint_sync_command command{};
  command.command = code;
  command.argument = argument;
  return set(GLINT_SYNC_COMMAND, command);
}

bool TestBench::edge() {
  if (!hardware.edge()) return false;
  device.on_edge(now);
  return true;
}

void TestBench::stage_period_us(std::uint32_t us, std::uint8_t flags, std::uint32_t pulses) {
  auto run = get<glint_sync_run>(GLINT_SYNC_RUN);
  run.period_ticks = us * 125;
  run.flags = flags;
  run.pulses = pulses;
  set(GLINT_SYNC_RUN, run);
}

void TestBench::stage_output(unsigned output, std::uint32_t delay_us, std::uint32_t width_us,
                             std::uint8_t every_n, std::uint8_t phase) {
  const auto id = static_cast<std::uint8_t>(GLINT_SYNC_OUTPUT + output);
  auto staged = get<glint_sync_output>(id);
  staged.flags |= GLINT_SYNC_OUTPUT_ENABLED;
  staged.delay_ticks = delay_us * 125;
  staged.width_ticks = width_us * 125;
  staged.every_n = every_n;
  staged.phase = phase;
  set(id, staged);
}

std::vector<glint_sync_input> TestBench::take_reports() {
  std::vector<glint_sync_input> reports;
  while (const glint_sync_input* report = device.take_report()) reports.push_back(*report);
  return reports;
}

std::vector<TestBench::Trigger> TestBench::triggers_in(const std::vector<glint_sync_input>& reports) {
  std::vector<Trigger> triggers;
  for (const glint_sync_input& report : reports) {
    std::uint64_t tick = report.tick;
    for (unsigned i = 0; i < report.count; ++i) {
      if (i > 0) tick += report.step_ticks[i - 1];
      triggers.push_back({tick, report.sequence + i, report.outputs[i], report.trigger_flags[i]});
    }
  }
  return triggers;
}

}  // namespace glint::board
