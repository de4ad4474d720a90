// SPDX-License-Identifier: MIT
// What the logic needs of the chip: outputs that make pulses, a gate, a measuring input.
#pragma once

#include <stdint.h>

namespace glint::board {

/// Each output works off segments: low for some time, then high for some time or not at all. An output that
/// has no segment stays low. In between `prepare` and `halt`, segments lie end to end; how many fit is at
/// least two beside the one under way.
class PulseHardware {
 public:
  struct Setup {
    uint8_t active_low;  ///< mask of outputs
    bool sync_out;
    bool external;      ///< every segment waits for the gate before its time begins; else only the first does
    bool falling_edge;  ///< of sync in, where external
    int measured = -1;  ///< output that the self-test measures at sync in; -1: none
  };

  /// Stops what was; all outputs idle, gate closed.
  virtual void prepare(const Setup& setup) = 0;
  /// `low` ticks from the end of the segment before (first, or external: from the gate), then `width`; 0: no
  /// pulse.
  virtual void feed(unsigned output, uint32_t low, uint32_t width) = 0;
  /// Words that wait, two a segment; the one under way has none or one of its own left.
  virtual unsigned waiting_words(unsigned output) const = 0;
  /// An output had no segment when it needed one, since prepare(). Not to be asked where external.
  virtual bool ran_dry() const = 0;
  /// Lets all outputs begin in the same tick, and returns that tick. Not where external.
  virtual uint64_t open_gate() = 0;
  /// External: the gate is sync in from now on, until the next edge. False: sync in is active; try again
  /// later. `missed`: there was an edge since the last call that nobody waited for.
  virtual bool arm(bool& missed) = 0;
  /// External: closes the gate again. True: an edge had come before, which is still told.
  virtual bool disarm() = 0;
  /// All outputs idle at once, gate closed.
  virtual void halt() = 0;
  /// Keeps strobes idle at the pins, whatever their segments say, until called with false.
  virtual void hold_strobes(bool hold) = 0;
  /// Self-test: the next pulse seen at sync in; false: no further one.
  virtual bool take_measured(uint32_t& low, uint32_t& width) = 0;
  virtual uint32_t measure_resolution() const = 0;

 protected:
  ~PulseHardware() = default;
};

}  // namespace glint::board
