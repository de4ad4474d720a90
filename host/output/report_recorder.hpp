// SPDX-License-Identifier: MIT
// Remembers, in fixed memory, what a run's report shows: trajectories, rates, latencies.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/base/ids.hpp"
#include "host/output/latency_histogram.hpp"
#include "host/output/report.hpp"
#include "host/track/tracker.hpp"

namespace glint {

struct RecorderOptions {
  double history_s = 4.0;        ///< how much of each trajectory the picture shows, counted from the end
  double sample_rate_hz = 45.0;  ///< trajectories are thinned to this
  std::size_t max_samples = std::size_t{1} << 17;  ///< 24 bytes each; then the oldest are overwritten
  std::size_t max_bins = 2048;                     ///< of the rate plot; then two neighbours become one
};

struct ReportTick {
  Timestamp exposed{};
  std::span<const TrackedPoint> points;
  double detection_s = -1.0;        ///< negative: not measured
  double end_to_end_s = -1.0;       ///< last byte in host memory to points; negative: not measured
  double stamp_to_output_s = -1.0;  ///< driver's stamp to the output having it; negative: not measured
};

/// Thread-bound. add() allocates nothing.
class ReportRecorder {
 public:
  explicit ReportRecorder(const RecorderOptions& options = {});

  void add(const ReportTick& tick) noexcept;
  /// Fills the measured fields of `data` (trajectories, rates, latencies); leaves the others.
  void fill(ReportData& data) const;

  const LatencyHistogram& detection() const noexcept { return detection_; }
  const LatencyHistogram& end_to_end() const noexcept { return end_to_end_; }
  const LatencyHistogram& stamp_to_output() const noexcept { return stamp_to_output_; }

 private:
  struct Sample {
    TrackId id{};
    float x_m = 0.0f, y_m = 0.0f, z_m = 0.0f;
    double time_s = 0.0;  // since the first tick
  };
  struct Bin {
    std::uint32_t ticks = 0;
    std::uint64_t points = 0;
  };
  void count_in_bin(double time_s, std::size_t points) noexcept;
  void fill_trajectories(ReportData& data) const;
  void fill_rates(ReportData& data) const;

  RecorderOptions options_;
  std::vector<Sample> samples_;  // a ring
  std::uint64_t samples_seen_ = 0;
  std::vector<Bin> bins_;
  std::size_t bins_used_ = 0;
  double bin_s_ = 1.0, next_sample_s_ = 0.0, last_s_ = 0.0;
  std::uint64_t ticks_ = 0;
  Timestamp first_{};
  LatencyHistogram detection_, end_to_end_, stamp_to_output_;
};

}  // namespace glint
