// SPDX-License-Identifier: MIT
// Where tracked points go: CSV, JSON lines, or nowhere.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "host/base/ids.hpp"
#include "host/body/body_tracker.hpp"
#include "host/output/output_spec.hpp"
#include "host/output/record_file.hpp"
#include "host/track/tracker.hpp"

namespace glint {

/// The rows of one tick; the points are only borrowed.
struct TrackRow {
  TriggerNo trigger{};
  Timestamp exposed{};  ///< middle of the exposure
  std::span<const TrackedPoint> points;
  std::uint32_t frames = 0;                 ///< bit set of cameras whose frame was used
  std::optional<double> exposed_error_s{};  ///< bound of what `exposed` is off by; nothing: not known
  std::optional<Timestamp> stamped{};       ///< of the driver, latest of the tick's frames; nothing: not live
  /// Coded pulses: bit set of cameras that may show another pulse; nothing: no code in use, nobody knows.
  std::optional<std::uint32_t> unproven{};
  bool dark = false;  ///< the light was off on purpose
  std::span<const IdentityEvent> identity{};
  std::span<const TrackedBody> bodies{};
};

/// Thread-bound. Writing allocates nothing once warm. May block on a slow pipe.
class TrackSink {
 public:
  virtual ~TrackSink() = default;
  [[nodiscard]] virtual SinkStatus write(const TrackRow& row) noexcept = 0;
  /// Hands over what is buffered; call about once a second so that a reader of the file sees it grow.
  [[nodiscard]] virtual SinkStatus flush() noexcept = 0;
  [[nodiscard]] virtual SinkStatus finish() noexcept = 0;
  virtual SinkCounters counters() const noexcept = 0;
  /// Why writing failed; empty while all is well.
  virtual const std::string& problem() const noexcept = 0;
};

/// CSV: one row a point,
/// `tick,time_ns,id,x_m,y_m,z_m,residual_px,cameras,aligned,kind,age,ambiguous,sd_m`; cameras are numbered
/// from 1 in rig order and joined by '+' (1+2+4). aligned is 1 if all of them are proven to show this very
/// pulse, 0 if one may not, and empty (JSON: null) without coded pulses. kind is measured, single-view or
/// predicted; age counts frames since two cameras measured the marker; ambiguous is the id of the track that
/// may be this marker instead, or empty (JSON: null); sd_m is the standard deviation per axis, root mean
/// square over the three. JSON lines: one object a tick, also for a tick without points, with `cameras` whose
/// frame was used, and of live cameras `time_error_ns` and `stamped_ns`; `"dark":true` if the light was off
/// on purpose; and where something became of identities, `identity`: objects with `kind` (ambiguous, kept,
/// swapped, unresolved), `a` and `b`, and if unresolved `new_a` and `new_b` (null: that track had ended).
/// Times count from the epoch of Timestamp. `bodies`: the rigid bodies that are looked for; if there are any,
/// a line of JSON also has `bodies` (host/output/body_sink.hpp). Throws Error when the file cannot be
/// written.
std::unique_ptr<TrackSink> make_track_sink(const OutputSpec& spec, std::span<const BodyModel> bodies = {});

}  // namespace glint
