// SPDX-License-Identifier: MIT
// Collects what the report shows.
#include "host/output/report_recorder.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace glint {

namespace {

constexpr std::size_t kMostPointsShown = 24000;  // keeps the page near a megabyte
constexpr double kGapPeriods = 3.5;              // a track that was away longer is drawn in two pieces

}  // namespace

ReportRecorder::ReportRecorder(const RecorderOptions& options) : options_(options) {
  samples_.resize(std::max<std::size_t>(1, options_.max_samples));
  bins_.resize(std::max<std::size_t>(2, options_.max_bins));
}

void ReportRecorder::add(const ReportTick& tick) noexcept {
  detection_.add(tick.detection_s);
  end_to_end_.add(tick.end_to_end_s);
  stamp_to_output_.add(tick.stamp_to_output_s);
  if (ticks_ == 0) first_ = tick.exposed;
  ++ticks_;
  // A source whose clock goes back stays where it was.
  last_s_ = std::max(last_s_, seconds_between(first_, tick.exposed));
  count_in_bin(last_s_, tick.points.size());
  // Half a tick early is near enough: rates that do not divide evenly then give an even picture.
  if (last_s_ + 1e-4 < next_sample_s_) return;
  const double period_s = 1.0 / options_.sample_rate_hz;
  next_sample_s_ = std::max(next_sample_s_ + period_s, last_s_ + 0.5 * period_s);
  for (const TrackedPoint& point : tick.points) {
    Sample& sample = samples_[samples_seen_++ % samples_.size()];
    sample.id = point.id;
    sample.x_m = static_cast<float>(point.position_in_world.x());
    sample.y_m = static_cast<float>(point.position_in_world.y());
    sample.z_m = static_cast<float>(point.position_in_world.z());
    sample.time_s = last_s_;
  }
}

void ReportRecorder::count_in_bin(double time_s, std::size_t points) noexcept {
  while (time_s >= bin_s_ * static_cast<double>(bins_.size())) {
    for (std::size_t i = 0; i < bins_.size(); ++i) {
      Bin merged;
      if (2 * i < bins_used_) merged = bins_[2 * i];
      if (2 * i + 1 < bins_used_) {
        merged.ticks += bins_[2 * i + 1].ticks;
        merged.points += bins_[2 * i + 1].points;
      }
      bins_[i] = merged;
    }
    bins_used_ = (bins_used_ + 1) / 2;
    bin_s_ *= 2.0;
  }
  const auto bin = static_cast<std::size_t>(time_s / bin_s_);
  bins_used_ = std::max(bins_used_, bin + 1);
  ++bins_[bin].ticks;
  bins_[bin].points += points;
}

void ReportRecorder::fill(ReportData& data) const {
  data.detection = detection_;
  data.end_to_end = end_to_end_;
  data.stamp_to_output = stamp_to_output_;
  data.history_s = std::min(options_.history_s, last_s_);
  fill_trajectories(data);
  fill_rates(data);
}

void ReportRecorder::fill_trajectories(ReportData& data) const {
  struct Walk {
    ReportTrajectory trajectory;
    double last_s = 0.0;
    std::size_t seen = 0;
  };
  const std::uint64_t kept = std::min<std::uint64_t>(samples_seen_, samples_.size());
  const double from_s = last_s_ - options_.history_s;
  std::size_t shown = 0;
  for (std::uint64_t n = samples_seen_ - kept; n < samples_seen_; ++n) {
    if (samples_[n % samples_.size()].time_s >= from_s) ++shown;
  }
  const std::size_t thin = 1 + shown / kMostPointsShown;
  const double gap_s = kGapPeriods / options_.sample_rate_hz;
  std::map<TrackId, Walk> walks;
  for (std::uint64_t n = samples_seen_ - kept; n < samples_seen_; ++n) {
    const Sample& sample = samples_[n % samples_.size()];
    const Eigen::Vector3d point = Eigen::Vector3f(sample.x_m, sample.y_m, sample.z_m).cast<double>();
    if (sample.time_s < from_s || !point.allFinite()) continue;
    Walk& walk = walks[sample.id];
    auto& pieces = walk.trajectory.pieces_in_world;
    if (pieces.empty() || sample.time_s - walk.last_s > gap_s) {
      pieces.emplace_back();
      walk.seen = 0;
    }
    if (walk.seen++ % thin == 0) pieces.back().push_back(point);
    walk.last_s = sample.time_s;
  }
  data.trajectories.clear();
  for (auto& [id, walk] : walks) {
    walk.trajectory.id = id;
    data.trajectories.push_back(std::move(walk.trajectory));
  }
}

void ReportRecorder::fill_rates(ReportData& data) const {
  data.rates.clear();
  const double period_s = ticks_ > 1 ? last_s_ / static_cast<double>(ticks_ - 1) : 0.0;
  for (std::size_t i = 0; i < bins_used_; ++i) {
    ReportRate rate;
    rate.start_s = bin_s_ * static_cast<double>(i);
    // The last bin is counted for as long as it lasted; a sliver of one says nothing.
    const double length_s = i + 1 < bins_used_ ? bin_s_ : std::min(bin_s_, last_s_ + period_s - rate.start_s);
    if (bins_used_ > 1 && length_s < 0.25 * bin_s_) continue;
    rate.ticks_per_s = length_s > 0.0 ? bins_[i].ticks / length_s : 0.0;
    rate.points_per_tick = bins_[i].ticks > 0 ? static_cast<double>(bins_[i].points) / bins_[i].ticks : 0.0;
    data.rates.push_back(rate);
  }
}

}  // namespace glint
