// SPDX-License-Identifier: MIT
#include "firmware/core/frame_planner.hpp"

#include "firmware/protocol/pulse_code.h"

namespace glint::board {
namespace {

bool dark(const glint_sync_run& run, uint32_t sequence) {
  if (run.code_group == 0) return false;
  const uint32_t group_no = sequence / run.code_group;
  return sequence - group_no * run.code_group ==
         glint_pulse_code_dark(run.code_seed, run.code_group, group_no);
}

bool has_turn(const glint_sync_output& output, uint32_t sequence) {
  return output.every_n == 1 || sequence % output.every_n == output.phase;
}

}  // namespace

FramePlanner::FramePlanner(uint64_t now) {
  for (uint64_t& tick : free_from_) tick = now + limits_.least_interval(limits_.max_width);
}

void FramePlanner::begin_run(uint64_t now) {
  for (uint64_t& end : ends_) end = now;
  held_strobes_ = 0;
}

uint64_t FramePlanner::earliest_frame(const Plan& plan, uint64_t wanted, uint32_t sequence) const {
  uint64_t tick = wanted;
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    const uint32_t delay = plan.enabled(i) ? plan.outputs[i].delay_ticks : 0;
    uint64_t rise = ends_[i] + kMinGap;
    const bool fires = plan.enabled(i) && has_turn(plan.outputs[i], sequence);
    if (is_strobe(i) && fires && free_from_[i] > rise) rise = free_from_[i];
    if (tick + delay < rise) tick = rise - delay;
  }
  return tick;
}

Frame FramePlanner::plan_frame(const Plan& plan, uint64_t tick, uint32_t sequence, bool locked) {
  Frame frame;
  frame.tick = tick;
  frame.sequence = sequence;
  frame.outputs = 0;
  frame.flags = 0;
  const bool is_dark = dark(plan.run, sequence);
  if (is_dark) frame.flags |= GLINT_SYNC_TRIGGER_DARK;
  if (locked) frame.flags |= GLINT_SYNC_TRIGGER_LOCKED;
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    const glint_sync_output& output = plan.outputs[i];
    Segment& segment = frame.segments[i];
    segment = {tick, 0, 0};
    if (plan.enabled(i)) {
      segment.begin_tick += output.delay_ticks;
      if (has_turn(output, sequence)) segment.width = output.width_ticks;
    }
    if (is_strobe(i)) {
      if (is_dark && segment.width > plan.run.dark_width_ticks) segment.width = plan.run.dark_width_ticks;
      if (locked) segment.width = 0;
      if (segment.width != 0 && !may_rise(i, segment)) {
        segment.width = 0;
        frame.flags |= GLINT_SYNC_TRIGGER_HELD;
        ++held_strobes_;
      }
      if (segment.width != 0) {
        free_from_[i] = segment.begin_tick + limits_.least_interval(segment.width);
        const uint64_t end = segment.begin_tick + segment.width;
        if (end > last_strobe_end_) last_strobe_end_ = end;
      }
    }
    if (segment.width != 0) frame.outputs |= static_cast<uint8_t>(1u << i);
    segment.low = static_cast<uint32_t>(segment.begin_tick - ends_[i]);
    ends_[i] = segment.begin_tick + segment.width;
  }
  return frame;
}

void FramePlanner::shift(Frame& last, uint64_t ticks) {
  last.tick += ticks;
  for (unsigned i = 0; i < GLINT_SYNC_OUTPUTS; ++i) {
    last.segments[i].begin_tick += ticks;
    ends_[i] += ticks;
    if (is_strobe(i) && last.segments[i].width != 0) free_from_[i] += ticks;
  }
  last_strobe_end_ += ticks;
}

bool FramePlanner::may_rise(unsigned output, const Segment& segment) const {
  return segment.begin_tick >= free_from_[output] && segment.width <= limits_.max_width;
}

uint64_t FramePlanner::last_end() const {
  uint64_t last = 0;
  for (const uint64_t end : ends_)
    if (end > last) last = end;
  return last;
}

}  // namespace glint::board
