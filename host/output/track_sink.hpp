// SPDX-License-Identifier: MIT
// Where tracked points go: CSV, JSON lines, or nowhere.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "host/base/ids.hpp"
#include "host/output/output_spec.hpp"
#include "host/output/record_file.hpp"
#include "host/track/tracker.hpp"

namespace glint {

/// The rows of one tick; the points are only borrowed.
struct TrackRow {
  TriggerNo trigger{};
  Timestamp exposed{};  ///< middle of the exposure
  std::span<const TrackedPoint> points;
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

/// CSV: one row a point, `tick,time_ns,id,x_m,y_m,z_m,residual_px,cameras`; cameras are numbered from 1
/// in rig order and joined by '+' (1+2+4). JSON lines: one object a tick, also for a tick without
/// points. time_ns counts from the epoch of Timestamp. Throws Error when the file cannot be written.
std::unique_ptr<TrackSink> make_track_sink(const OutputSpec& spec);

}  // namespace glint
