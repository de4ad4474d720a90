// SPDX-License-Identifier: MIT
// The loops count what they should, end when they should, and notice errors that show only under load.
#include "host/bench/measure.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/unit/bench/altered_detector.hpp"

namespace glint::bench {
namespace {

using test::AlteredDetector;
using ::testing::HasSubstr;

class Measure : public ::testing::Test {
 protected:
  static SceneOptions small() {
    SceneOptions options;
    options.cameras = 2;
    options.ticks = 3;
    options.width_px = 128;
    options.height_px = 96;
    options.blobs_per_camera = 2;
    return options;
  }

  std::unique_ptr<gpu::Detector> cpu_detector(unsigned depth) {
    gpu::DetectorOptions options;
    options.depth = depth;
    auto detector = gpu::make_cpu_detector(scene_.formats(), options);
    set_limits(scene_, *detector);
    return detector;
  }

  Scene scene_{small()};
  Expected expected_{scene_};
  Conditions conditions_{5, 40, 3, 10.0, 500.0};
};

TEST_F(Measure, TakesAsManySamplesAsAsked) {
  const auto detector = cpu_detector(3);
  Drive drive(scene_, expected_, *detector, 2);
  Row row;
  warm_up(drive, conditions_);
  measure_latency(drive, conditions_, row);
  EXPECT_EQ(row.wall.summary.count, 40u);
  EXPECT_EQ(row.cpu.summary.count, 40u);
  ASSERT_EQ(row.stages.size(), 1u);
  EXPECT_EQ(row.stages[0].name, "detect");
  EXPECT_EQ(row.stages[0].time.summary.count, 40u);
  EXPECT_LE(row.stages[0].time.summary.p50, row.wall.summary.p50);
  measure_throughput(drive, conditions_, row);
  EXPECT_EQ(row.interval.summary.count, 40u);
  EXPECT_EQ(row.depth, 3u);
  EXPECT_GT(row.ticks_per_s, 0.0);
  const Paced paced = measure_pace(drive, conditions_);
  EXPECT_EQ(paced.latency.summary.count, 40u);
  EXPECT_EQ(drive.outcome(), Outcome::Ok) << drive.problem();
}

TEST_F(Measure, EndsWhenTimeIsUp) {
  const auto detector = cpu_detector(3);
  Drive drive(scene_, expected_, *detector, 2);
  conditions_.ticks = 100000;
  conditions_.max_time_s = 0.05;
  conditions_.rate_hz = 100.0;
  const auto began = std::chrono::steady_clock::now();
  const Paced paced = measure_pace(drive, conditions_);
  EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(5));
  EXPECT_GE(paced.latency.summary.count, 1u);
  EXPECT_LE(paced.latency.summary.count, 7u);  // 50 ms at 100 Hz, and the one before time was up
}

TEST_F(Measure, KeepsTheSchedule) {
  const auto detector = cpu_detector(2);
  Drive drive(scene_, expected_, *detector, 2);
  conditions_.ticks = 30;
  conditions_.rate_hz = 200.0;
  const auto began = std::chrono::steady_clock::now();
  EXPECT_EQ(measure_pace(drive, conditions_).latency.summary.count, 30u);
  EXPECT_GE(std::chrono::steady_clock::now() - began,
            std::chrono::milliseconds(145));  // 29 periods
}

TEST_F(Measure, CountsMissedDeadlines) {
  AlteredDetector slow(scene_.formats(), [](unsigned tick, auto&) {
    if (tick % 10 == 5) std::this_thread::sleep_for(std::chrono::milliseconds(70));
  });
  set_limits(scene_, slow);
  Drive drive(scene_, expected_, slow, 2);
  conditions_.ticks = 20;
  conditions_.rate_hz = 20.0;
  const Paced paced = measure_pace(drive, conditions_);
  EXPECT_EQ(paced.latency.summary.count, 20u);
  EXPECT_GE(paced.missed, 2u);
  EXPECT_LT(paced.missed, 20u);
  EXPECT_GE(paced.latency.summary.max, 0.07);
}

TEST_F(Measure, GivesUpEarlyWhenAskedTo) {
  AlteredDetector slow(scene_.formats(),
                       [](unsigned, auto&) { std::this_thread::sleep_for(std::chrono::milliseconds(5)); });
  set_limits(scene_, slow);
  Drive drive(scene_, expected_, slow, 2);
  conditions_.rate_hz = 1000.0;
  EXPECT_EQ(measure_pace(drive, conditions_, 2).latency.summary.count, 3u);
}

TEST_F(Measure, SeesBlobsLostUnderLoad) {
  AlteredDetector loses(scene_.formats(),
                        [](unsigned tick, std::vector<std::vector<gpu::BlobRecord>>& cameras) {
                          if (tick == 17) cameras[0].pop_back();
                        });
  set_limits(scene_, loses);
  Drive drive(scene_, expected_, loses, 2);
  Row row;
  measure_latency(drive, conditions_, row);
  EXPECT_EQ(drive.outcome(), Outcome::Wrong);
  EXPECT_THAT(drive.problem(), HasSubstr("1 of 40 ticks"));
}

TEST_F(Measure, SeesABreakdown) {
  AlteredDetector breaks(scene_.formats(), {}, 3);
  set_limits(scene_, breaks);
  breaks.break_after(6);
  Drive drive(scene_, expected_, breaks, 2);
  Row row;
  measure_throughput(drive, conditions_, row);
  EXPECT_EQ(row.interval.summary.count, 0u);
  EXPECT_EQ(drive.outcome(), Outcome::Failed);
  EXPECT_EQ(drive.problem(), "it broke down: gone");
}

TEST(StageLog, AddsUpStagesOfOneNameAndSkipsTicksWithout) {
  StageLog log(3);
  log.add(0, {{"upload", 1.0}, {"find", 4.0}, {"upload", 2.0}});
  log.add(2, {{"find", 5.0}, {"join", 6.0}});
  const std::vector<StageSeries> series = log.series();
  ASSERT_EQ(series.size(), 3u);
  EXPECT_EQ(series[0].name, "upload");
  EXPECT_EQ(series[0].time.samples, std::vector<double>{3.0});
  EXPECT_EQ(series[1].time.samples, (std::vector<double>{4.0, 5.0}));
  EXPECT_EQ(series[2].time.samples, std::vector<double>{6.0});
}

TEST(ProcessCpu, GrowsWithWork) {
  const double before = process_cpu_s();
  volatile double x = 0.0;
  while (process_cpu_s() - before < 0.01) x = x + 1.0;
  EXPECT_GT(x, 1000.0);
}

}  // namespace
}  // namespace glint::bench
