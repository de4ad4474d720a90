// SPDX-License-Identifier: MIT
// The picture of a run: one HTML page that needs nothing but itself.
#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "host/base/ids.hpp"
#include "host/geometry/camera.hpp"
#include "host/output/latency_histogram.hpp"

namespace glint {

struct ReportRow {
  std::string name, value;
  std::string note{};     ///< small print below the value; may be empty
  bool headline = false;  ///< shown large, at the top
};

/// One track; a new piece begins where it was not seen for a while.
struct ReportTrajectory {
  TrackId id{};
  std::vector<std::vector<Eigen::Vector3d>> pieces_in_world;
};

struct ReportRate {
  double start_s = 0.0;  ///< since the first tick
  double ticks_per_s = 0.0;
  double points_per_tick = 0.0;
};

struct ReportData {
  std::string title, subtitle;     ///< plain text: source and device, say
  std::vector<ReportRow> summary;  ///< in the order shown
  std::vector<CameraCalibration> cameras;
  double nominal_rate_hz = 0.0;  ///< drawn as a line in the rate plot; 0: unknown
  // What ReportRecorder::fill() measures:
  std::vector<ReportTrajectory> trajectories;
  double history_s = 0.0;
  std::vector<ReportRate> rates;
  LatencyHistogram detection, end_to_end;
  LatencyHistogram stamp_to_output;  ///< of live cameras; not shown if empty
};

/// The page as text.
std::string report_html(const ReportData& data);

/// A report that will be written: made before a long run, so that a bad path is known at once. The file
/// appears whole or not at all.
class ReportFile {
 public:
  /// An existing file is refused unless `force`. Throws Error.
  ReportFile(std::string path, bool force);
  ~ReportFile();
  ReportFile(const ReportFile&) = delete;
  ReportFile& operator=(const ReportFile&) = delete;

  /// Throws Error, the old file (if any) being untouched.
  void write(const ReportData& data);
  const std::string& path() const noexcept { return path_; }

 private:
  std::string path_, unfinished_path_;
  bool force_ = false, written_ = false;
};

/// ReportFile in one step, for when the data is there already.
void write_report(const std::string& path, const ReportData& data, bool force = false);

}  // namespace glint
