// SPDX-License-Identifier: MIT
// One report that the board sent by itself, or that was fetched: bytes to values, nothing trusted.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <variant>

#include "firmware/protocol/sync_report.h"

namespace glint::sync {

/// One frame of a run.
struct Trigger {
  std::uint64_t tick = 0;      ///< beginning of the frame; outputs are `delay` behind it
  std::uint32_t sequence = 0;  ///< counted from 0 in each run
  std::uint8_t outputs = 0;    ///< bit i: output i fired
  std::uint8_t flags = 0;      ///< glint_sync_trigger_flags

  bool dark() const noexcept { return (flags & GLINT_SYNC_TRIGGER_DARK) != 0; }
  bool locked() const noexcept { return (flags & GLINT_SYNC_TRIGGER_LOCKED) != 0; }
  bool external() const noexcept { return (flags & GLINT_SYNC_TRIGGER_EXTERNAL) != 0; }
  bool held() const noexcept { return (flags & GLINT_SYNC_TRIGGER_HELD) != 0; }
  bool last() const noexcept { return (flags & GLINT_SYNC_TRIGGER_LAST) != 0; }
  bool operator==(const Trigger&) const = default;
};

/// One to four frames.
struct Triggers {
  std::array<Trigger, GLINT_SYNC_TRIGGERS_PER_REPORT> list{};
  std::uint8_t count = 0;

  std::span<const Trigger> all() const noexcept { return {list.data(), count}; }
};

/// Anything else that happened.
struct Event {
  enum class Kind : std::uint8_t {
    Booted = GLINT_SYNC_KIND_BOOTED,    ///< first of an epoch; detail: glint_sync_reset
    Started = GLINT_SYNC_KIND_STARTED,  ///< tick, sequence: of the first frame to come
    Stopped = GLINT_SYNC_KIND_STOPPED,  ///< see below; sequence: frames of the run
    Applied = GLINT_SYNC_KIND_APPLIED,  ///< sequence: first frame with the new plan
    Locked = GLINT_SYNC_KIND_LOCKED,    ///< supply too high; detail: millivolts
    Rearmed = GLINT_SYNC_KIND_REARMED,  ///< sequence: first frame with strobes; detail: millivolts
    Unknown = 0xfe,                     ///< of a newer firmware with the same major protocol number
  };
  Kind kind = Kind::Unknown;
  std::uint64_t tick = 0;
  std::uint32_t sequence = 0;
  std::uint32_t detail = 0;

  /// Of Stopped: glint_sync_stop, and the glint_sync_fault behind it.
  std::uint32_t stop_reason() const noexcept { return detail & 0xffu; }
  std::uint32_t fault() const noexcept { return detail >> 8; }
};

/// Answer to FETCH: the report is no longer, or not yet, held.
struct NotHeld {
  std::uint32_t oldest_held = 0;
};

using ReportContent = std::variant<Triggers, Event, NotHeld>;

struct InputReport {
  std::uint32_t epoch = 0;
  std::uint32_t report_no = 0;
  std::uint16_t run = 0;
  std::uint16_t supply_mv = 0;
  std::uint16_t unsent = 0;
  std::uint8_t queued = 0;
  std::uint8_t flags = 0;  ///< glint_sync_flags
  ReportContent content;

  /// The board sent this after that tick: the last trigger. Events say nothing of the kind, STARTED tells of
  /// what is to come.
  std::optional<std::uint64_t> sent_after() const noexcept;
};

enum class Flaw : std::uint8_t {
  None,
  Length,    ///< not GLINT_SYNC_REPORT_BYTES
  ReportId,  ///< not the one that was expected
  Protocol,  ///< another major number
  Kind,      ///< an answer to FETCH that was not asked for
  Count,     ///< no trigger, more than four, or triggers in an event
  Tick,      ///< triggers that do not follow each other in time
};
const char* flaw_text(Flaw flaw) noexcept;

struct ParsedReport {
  Flaw flaw = Flaw::None;
  InputReport report;  ///< only if there is no flaw
};

/// `bytes` as received, of any length; `report_id` is GLINT_SYNC_INPUT or GLINT_SYNC_FETCH.
ParsedReport parse_input(std::span<const std::uint8_t> bytes, std::uint8_t report_id) noexcept;

}  // namespace glint::sync
