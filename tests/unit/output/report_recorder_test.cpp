// SPDX-License-Identifier: MIT
// What a run leaves behind for its report, and that memory stays bounded.
#include "host/output/report_recorder.hpp"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>

namespace glint {
namespace {

Timestamp at_s(double seconds) {
  return Timestamp(std::chrono::nanoseconds(std::int64_t{5'000'000'000} + std::llround(seconds * 1e9)));
}

TrackedPoint point(std::uint32_t id, double x_m) {
  TrackedPoint p;
  p.id = TrackId(id);
  p.position_in_world = {x_m, 2, 3};
  return p;
}

TEST(ReportRecorder, ThinsTrajectoriesAndKeepsTheLastSeconds) {
  RecorderOptions options;
  options.history_s = 2.0;
  options.sample_rate_hz = 30.0;
  ReportRecorder recorder(options);
  for (int tick = 0; tick < 900; ++tick) {
    const std::vector<TrackedPoint> points{point(7, tick)};
    recorder.add({at_s(tick / 90.0), points});
  }
  ReportData data;
  recorder.fill(data);
  ASSERT_EQ(data.trajectories.size(), 1u);
  EXPECT_EQ(number(data.trajectories[0].id), 7u);
  ASSERT_EQ(data.trajectories[0].pieces_in_world.size(), 1u);
  const auto& piece = data.trajectories[0].pieces_in_world[0];
  EXPECT_NEAR(static_cast<double>(piece.size()), 60.0, 2.0);
  EXPECT_GE(piece.front().x(), 899 - 2 * 90 - 3);
  EXPECT_GE(piece.back().x(), 895);
  for (std::size_t i = 1; i < piece.size(); ++i) EXPECT_EQ(piece[i].x() - piece[i - 1].x(), 3.0);
}

TEST(ReportRecorder, ATrackThatWasAwayIsDrawnInPieces) {
  ReportRecorder recorder;
  for (int tick = 0; tick < 180; ++tick) {
    std::vector<TrackedPoint> points{point(1, tick)};
    if (tick < 60 || tick >= 120) points.push_back(point(2, tick));
    recorder.add({at_s(tick / 90.0), points});
  }
  ReportData data;
  recorder.fill(data);
  ASSERT_EQ(data.trajectories.size(), 2u);
  EXPECT_EQ(data.trajectories[0].pieces_in_world.size(), 1u);
  ASSERT_EQ(data.trajectories[1].pieces_in_world.size(), 2u);
  EXPECT_LT(data.trajectories[1].pieces_in_world[0].back().x(), 60);
  EXPECT_GE(data.trajectories[1].pieces_in_world[1].front().x(), 120);
}

TEST(ReportRecorder, RatesShowMissedTicks) {
  ReportRecorder recorder;
  const std::vector<TrackedPoint> points{point(1, 0), point(2, 0), point(3, 0)};
  for (int tick = 0; tick < 450; ++tick) {
    if (tick >= 180 && tick < 225) continue;  // half of the third second
    recorder.add({at_s((tick + 0.5) / 90.0), points});
  }
  ReportData data;
  recorder.fill(data);
  ASSERT_EQ(data.rates.size(), 5u);
  const double wanted[] = {90, 90, 45, 90, 90};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(data.rates[i].ticks_per_s, wanted[i], 2.0) << i;
    EXPECT_EQ(data.rates[i].start_s, static_cast<double>(i));
    EXPECT_EQ(data.rates[i].points_per_tick, 3.0);
  }
}

TEST(ReportRecorder, ALongRunGetsWiderBinsAndLosesNoTick) {
  RecorderOptions options;
  options.max_bins = 8;
  ReportRecorder recorder(options);
  for (int tick = 0; tick < 10 * 97; ++tick) recorder.add({at_s(tick / 10.0), {}});
  ReportData data;
  recorder.fill(data);
  ASSERT_LE(data.rates.size(), 8u);
  ASSERT_GE(data.rates.size(), 4u);
  for (const ReportRate& rate : data.rates) EXPECT_NEAR(rate.ticks_per_s, 10.0, 0.1);
  EXPECT_EQ(data.rates[1].start_s, 16.0);
}

TEST(ReportRecorder, AJumpOfAYearIsHarmless) {
  ReportRecorder recorder;
  recorder.add({at_s(0), {}});
  recorder.add({at_s(3.2e7), {}});
  recorder.add({at_s(1), {}});  // and back
  ReportData data;
  recorder.fill(data);
  EXPECT_FALSE(data.rates.empty());
}

TEST(ReportRecorder, TooManySamplesOverwriteTheOldest) {
  RecorderOptions options;
  options.max_samples = 100;
  ReportRecorder recorder(options);
  for (int tick = 0; tick < 90; ++tick) {
    std::vector<TrackedPoint> points;
    for (std::uint32_t id = 1; id <= 10; ++id) points.push_back(point(id, tick));
    recorder.add({at_s(tick / 45.0), points});
  }
  ReportData data;
  recorder.fill(data);
  ASSERT_EQ(data.trajectories.size(), 10u);
  std::size_t samples = 0;
  for (const auto& trajectory : data.trajectories) {
    for (const auto& piece : trajectory.pieces_in_world) samples += piece.size();
    EXPECT_GE(trajectory.pieces_in_world.back().back().x(), 85);
  }
  EXPECT_EQ(samples, 100u);
}

TEST(ReportRecorder, LatenciesThatWereNotMeasuredAreLeftOut) {
  ReportRecorder recorder;
  recorder.add({at_s(0), {}, 1e-3, 2e-3});
  recorder.add({at_s(1), {}});
  EXPECT_EQ(recorder.detection().count(), 1u);
  EXPECT_EQ(recorder.end_to_end().max_s(), 2e-3);
  EXPECT_EQ(recorder.stamp_to_output().count(), 0u);
  ReportData data;
  recorder.fill(data);
  EXPECT_EQ(report_html(data).find("driver's stamp"), std::string::npos);

  recorder.add({at_s(2), {}, 1e-3, 2e-3, 15e-3});
  recorder.fill(data);
  EXPECT_EQ(data.stamp_to_output.max_s(), 15e-3);
  EXPECT_NE(report_html(data).find("driver's stamp"), std::string::npos);
}

}  // namespace
}  // namespace glint
