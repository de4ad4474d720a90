// SPDX-License-Identifier: MIT
// What a run came to: for the terminal, the report and a JSON file.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/apps/body_text.hpp"
#include "host/apps/identity_text.hpp"
#include "host/assemble/code_alignment.hpp"
#include "host/assemble/ledger.hpp"
#include "host/health/camera_health.hpp"
#include "host/output/report.hpp"
#include "host/output/report_recorder.hpp"
#include "host/pipeline/track_pipeline.hpp"
#include "host/realtime/real_time.hpp"
#include "host/sim/score.hpp"
#include "host/sync/board_run.hpp"

namespace glint::apps {

struct RunSummary {
  std::string source, rig, device;
  double wall_s = 0.0, rate_hz = 0.0, nominal_rate_hz = 0.0;
  TrackCountersSnapshot counters;
  InputCounters input;
  std::optional<Ledger> ledger;        ///< only of live cameras
  std::optional<CodeReport> code;      ///< only with coded pulses
  std::optional<BoardCounters> board;  ///< only with a sync board
  std::string board_serial;
  HealthReport health;
  std::optional<double> plane_height_m;  ///< only of one camera
  std::vector<std::string> cameras;      ///< their names
  std::uint64_t ids = 0;
  KindCounts kinds;
  BodyRun bodies;  ///< empty: none were looked for
  LatencyHistogram detection, end_to_end;
  LatencyHistogram stamp_to_output, time_error;  ///< only of live cameras
  StampPoint stamp = StampPoint::HostArrival;    ///< what the last driver's stamp marked
  std::optional<RealTimeState> real_time;        ///< only where it was to be had
  std::optional<ScoreResult> score;              ///< only against a simulator's truth

  /// Frame sets that came to nothing or too late: dropped, delivered late, or not written.
  std::uint64_t missed() const noexcept { return input.dropped + input.late + counters.results_dropped; }
};

/// Name and value, in the order to show.
std::vector<ReportRow> summary_rows(const RunSummary& summary);
std::string summary_text(const RunSummary& summary);
std::string summary_json(const RunSummary& summary);

}  // namespace glint::apps
