// SPDX-License-Identifier: MIT
// Turns a plan into frames: when each output rises and falls, and which stay out.
#pragma once

#include "firmware/core/plan.hpp"

namespace glint::board {

/// One output in one frame. Every output has a segment in every frame, whether it fires or not, so that all
/// stay in step and any can be switched on while the others run.
struct Segment {
  uint64_t begin_tick;  ///< active edge; where nothing fires, the time at which the segment is over
  uint32_t low;         ///< from the end of the output's segment before
  uint32_t width;       ///< 0: nothing fires
};

struct Frame {
  uint64_t tick;
  uint32_t sequence;
  uint8_t outputs;  ///< mask of those that fire
  uint8_t flags;    ///< glint_sync_trigger_flags
  Segment segments[GLINT_SYNC_OUTPUTS];
};

/// Keeps in mind when each output's last segment ended and, for ever, when each strobe may rise again: no
/// order of calls makes a strobe longer than limits().max_width or shortens its pauses.
class FramePlanner {
 public:
  /// What happened before `now` is not known, so strobes have to wait as after the longest pulse.
  explicit FramePlanner(uint64_t now);

  const StrobeLimits& limits() const { return limits_; }
  void set_limits(const StrobeLimits& limits) { limits_ = limits; }

  /// Before the first frame of a run: all segments ended at `now`.
  void begin_run(uint64_t now);
  /// When the frame of that number may begin by this plan, at `wanted` or later: no pulse overlaps one
  /// planned before, and every strobe whose turn it is has paused long enough.
  uint64_t earliest_frame(const Plan& plan, uint64_t wanted, uint32_t sequence) const;
  /// Plans the frame that begins at `tick`. Strobes stay out when `locked`.
  Frame plan_frame(const Plan& plan, uint64_t tick, uint32_t sequence, bool locked);
  /// What was planned last happens that much later: the gate opened later than thought, an edge came.
  void shift(Frame& last, uint64_t ticks);
  /// When the last pulse planned, and the last strobe planned, are over.
  uint64_t last_end() const;
  uint64_t last_strobe_end() const { return last_strobe_end_; }
  /// Pulses left out by the pause rule since begin_run(): none, as long as frames begin at earliest_frame().
  uint32_t held_strobes() const { return held_strobes_; }

 private:
  bool may_rise(unsigned output, const Segment& segment) const;

  StrobeLimits limits_;
  uint64_t ends_[GLINT_SYNC_OUTPUTS]{};
  uint64_t free_from_[GLINT_SYNC_OUTPUTS]{};  // strobes only: earliest next rise
  uint64_t last_strobe_end_ = 0;
  uint32_t held_strobes_ = 0;
};

}  // namespace glint::board
