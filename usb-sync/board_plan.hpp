// SPDX-License-Identifier: MIT
// What the board is to do in a run, as a person sets it, and its translation to and from the board's ticks.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>

#include "firmware/protocol/sync_report.h"
#include "usb-sync/host_time.hpp"

namespace glint::sync {

inline constexpr std::size_t kOutputs = GLINT_SYNC_OUTPUTS;
/// Outputs 0 .. kTriggers - 1 trigger cameras, the others switch lights.
inline constexpr std::size_t kTriggers = GLINT_SYNC_TRIGGERS;

constexpr bool is_strobe(std::size_t output) noexcept { return output >= kTriggers; }
/// "output 1 (trigger)", "output 4 (strobe)".
std::string output_name(std::size_t output);

/// What begins a frame.
enum class FrameStart : std::uint8_t {
  Internal,    ///< the board's own clock, every `period`
  RisingEdge,  ///< an edge at sync in; `period` is the least time between two
  FallingEdge,
};

/// One output: a pulse in each frame whose number % every_n is phase.
struct OutputPlan {
  bool enabled = false;
  bool active_low = false;  ///< strobes: must be as the board's jumper says (Info::strobes_active_low)
  Seconds delay{0.0};       ///< from the beginning of the frame to the active edge; below the period
  Seconds width{0.0};
  int every_n = 1;  ///< 1 .. 255
  int phase = 0;    ///< below every_n

  bool operator==(const OutputPlan&) const = default;
};

/// In which frames the strobes stay dark, so that cameras can be aligned from their pictures alone: see
/// firmware/protocol/pulse_code.h.
struct DarkCode {
  std::uint32_t seed = 0;
  int group = 0;            ///< one dark frame in so many, GLINT_PULSE_CODE_LEAST_GROUP or more; 0: none
  Seconds dark_width{0.0};  ///< of strobes in dark frames; 0: off

  bool operator==(const DarkCode&) const = default;
};

struct BoardPlan {
  FrameStart start = FrameStart::Internal;
  Seconds period{1.0 / 90.0};
  std::uint32_t pulses = 0;                ///< frames of the run; 0: endless, 1: a single shot
  std::chrono::milliseconds keepalive{0};  ///< the board stops after so long without its host; 0: never
  bool sync_out = false;                   ///< sync out repeats output 0
  DarkCode code;
  std::array<OutputPlan, kOutputs> outputs{};

  bool operator==(const BoardPlan&) const = default;
};

/// The plan as the reports that carry it.
struct PlanReports {
  glint_sync_run run{};
  std::array<glint_sync_output, kOutputs> outputs{};
};

/// Each time becomes the nearest number of ticks. Throws Error if a value cannot be said in the report at
/// all (negative, not a number, more than 32 bits of ticks); what the board allows, the board decides.
PlanReports to_reports(const BoardPlan& plan, std::uint32_t tick_hz);

/// What the board makes of the reports. to_reports(from_reports(r)) is r: nothing is lost on this way.
BoardPlan from_reports(const PlanReports& reports, std::uint32_t tick_hz) noexcept;

/// The plan as it really will be, on the board's grid of ticks. Throws as to_reports().
inline BoardPlan on_grid(const BoardPlan& plan, std::uint32_t tick_hz) {
  return from_reports(to_reports(plan, tick_hz), tick_hz);
}

/// The nearest number of ticks. Throws Error that begins with `what` if that does not fit 32 bits.
std::uint32_t ticks_of(Seconds time, std::uint32_t tick_hz, const std::string& what);
constexpr Seconds seconds_of(std::uint64_t ticks, std::uint32_t tick_hz) noexcept {
  return Seconds(static_cast<double>(ticks) / static_cast<double>(tick_hz));
}

}  // namespace glint::sync
