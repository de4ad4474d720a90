// SPDX-License-Identifier: MIT
// Pulses made by the eight state machines of the two PIO blocks, one for each output.
#pragma once

#include "firmware/core/pulse_hardware.hpp"
#include "firmware/protocol/sync_report.h"

namespace glint::rp2040 {

/// Triggers are made by PIO 0, strobes by PIO 1. All machines wait for the same input before they begin: for
/// a pin that is not wired and whose level the processor overrides, or for sync in. So they begin in the same
/// tick, whatever the processor does meanwhile.
class PioPulses final : public board::PulseHardware {
 public:
  /// Pins become outputs, idle; before, the pads' pull-downs held them.
  explicit PioPulses(bool strobes_active_low);

  void prepare(const Setup& setup) override;
  void feed(unsigned output, uint32_t low, uint32_t width) override;
  unsigned waiting_words(unsigned output) const override;
  bool ran_dry() const override;
  uint64_t open_gate() override;
  bool arm(bool& missed) override;
  bool disarm() override;
  void halt() override;
  void hold_strobes(bool hold) override;
  bool take_measured(uint32_t& low, uint32_t& width) override;
  uint32_t measure_resolution() const override;

  /// In the interrupt of sync in: the tick in which a frame of outputs without delay begins.
  uint64_t take_edge();

 private:
  void start_machine(unsigned output);
  void start_measuring();
  void override_outputs();

  Setup setup_{};
  uint8_t active_low_;
  uint8_t used_ = 0;    // mask of machines that make pulses
  uint8_t fresh_ = 0;   // mask: no segment yet in this run
  uint8_t pulsed_ = 0;  // mask: the last segment had a pulse
  bool hold_strobes_ = false;
  bool low_taken_ = false;
  uint32_t measured_low_ = 0;
};

}  // namespace glint::rp2040
