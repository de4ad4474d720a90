// SPDX-License-Identifier: MIT
// Birth, life, crossing, bounce and death of tracks, from points given directly.
#include "host/track/tracker.hpp"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace glint {
namespace {

using std::chrono::microseconds;

constexpr microseconds kFrame(11111);
constexpr double kDt = 0.011111;

Point point_at(const Eigen::Vector3d& position, unsigned views = 4) {
  Point point;
  point.position_in_world = position;
  point.covariance_m2 = 1e-9 * Eigen::Matrix3d::Identity();
  point.views = views;
  point.certain = views >= 3;
  point.rms_px = 0.03;
  point.blob_of_camera.fill(-1);
  for (unsigned camera = 0; camera < views; ++camera) point.blob_of_camera[camera] = 0;
  return point;
}

class TrackerTest : public ::testing::Test {
 protected:
  explicit TrackerTest(std::span<const double> calibration_sd_px = {})
      : tracker_(options_, calibration_sd_px) {}
  const std::vector<TrackedPoint>& frame(const std::vector<Point>& points, int frames = 1) {
    now_ += frames * kFrame;
    tracker_.predict(Timestamp(now_), predictions_);
    tracker_.update(points, tracked_, counters_);
    return tracked_;
  }
  TrackOptions options_;
  Tracker tracker_;
  microseconds now_{1'000'000};
  std::vector<Prediction> predictions_;
  std::vector<TrackedPoint> tracked_;
  TrackCounters counters_;
};

TEST_F(TrackerTest, ThreeViewsArePublishedAtOnce) {
  const auto& out = frame({point_at({1, 2, 3}, 3)});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_NE(out[0].id, TrackId{});
  EXPECT_LT((out[0].position_in_world - Eigen::Vector3d(1, 2, 3)).norm(), 1e-9);
  EXPECT_EQ(out[0].cameras, 0b111u);
  EXPECT_EQ(out[0].residual_px, 0.03);
  EXPECT_EQ(counters_.started, 1u);
  EXPECT_EQ(counters_.published, 1u);
}

TEST_F(TrackerTest, WhatTheMatcherIsCertainOfIsPublishedAtOnce) {
  Point two = point_at({1, 2, 3}, 2), three = point_at({-1, 2, 3}, 3);
  two.certain = true;
  three.certain = false;
  const auto& out = frame({two, three});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].position_in_world.x(), 1.0);
}

TEST_F(TrackerTest, TwoViewsArePublishedWhenConfirmed) {
  EXPECT_TRUE(frame({point_at({0, 0, 1}, 2)}).empty());
  EXPECT_TRUE(frame({point_at({0.01, 0, 1}, 2)}).empty());
  EXPECT_EQ(counters_.unconfirmed, 2u);
  EXPECT_EQ(frame({point_at({0.02, 0, 1}, 2)}).size(), 1u);
  EXPECT_EQ(frame({point_at({0.03, 0, 1}, 2)}).size(), 1u);
}

TEST_F(TrackerTest, TwoViewsThatDoNotLastAreNeverPublished) {
  for (int k = 0; k < 20; ++k)  // a ghost that jumps
    EXPECT_TRUE(frame({point_at({k % 2 == 0 ? 1.0 : -1.0, 0, 1}, 2)}).empty());
  for (int k = 0; k < 20; ++k) {  // a ghost that comes and goes
    EXPECT_TRUE(frame({point_at({0, 2, 1}, 2)}).empty());
    EXPECT_TRUE(frame({}).empty());
  }
}

TEST_F(TrackerTest, AThirdViewConfirmsAtOnce) {
  EXPECT_TRUE(frame({point_at({0, 0, 1}, 2)}).empty());
  EXPECT_EQ(frame({point_at({0, 0, 1}, 3)}).size(), 1u);
}

TEST_F(TrackerTest, OcclusionToTwoViewsKeepsTheIdAndTheOutput) {
  const TrackId id = frame({point_at({0, 0, 1})})[0].id;
  for (int k = 1; k < 50; ++k) {
    const auto& out = frame({point_at({0.05 * k, 0, 1}, k > 10 && k < 40 ? 2 : 4)});
    ASSERT_EQ(out.size(), 1u) << k;
    EXPECT_EQ(out[0].id, id);
  }
}

/// Four cameras, of which one shows all of the marker.
class HiddenInPartTest : public TrackerTest {
 protected:
  HiddenInPartTest() : TrackerTest(kExactCalibration) {
    for (int k = 0; k < 30; ++k) id_ = frame({point_at({0, 0, 1})})[0].id;
  }
  Point blurred(const Eigen::Vector3d& position, double sd_m) {
    Point point = point_at(position, 2);
    point.covariance_m2 = sd_m * sd_m * Eigen::Matrix3d::Identity();
    point.doubtful = true;
    point.predicted_by = id_;
    return point;
  }
  static constexpr std::array<double, 4> kExactCalibration{};
  TrackId id_{};
};

TEST_F(HiddenInPartTest, IsMeasuredWhereItWasExpected) {
  const auto& out = frame({blurred({0, 0, 1}, 1e-3)});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].kind, SampleKind::Measured);
  EXPECT_EQ(out[0].age_frames, 0u);
}

TEST_F(HiddenInPartTest, IsNotMeasuredWhereItWasNotExpected) {
  const auto& out = frame({blurred({0, 0, 1.01}, 1e-3)});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].id, id_);
  EXPECT_EQ(out[0].kind, SampleKind::SingleView);
  EXPECT_EQ(out[0].age_frames, 1u);
}

TEST_F(HiddenInPartTest, IsNotMeasuredWhereTheTrackKnowsLittleItself) {
  for (int k = 0; k < 8; ++k) frame({});
  const auto& out = frame({blurred({0, 0, 1}, 1e-3)});
  ASSERT_EQ(out.size(), 1u);
  EXPECT_EQ(out[0].kind, SampleKind::SingleView);
}

// Dull in all cameras, it looks like what is left of a bright one; only time can tell.
TEST_F(TrackerTest, ADullMarkerIsPublishedLaterAndItsBrightnessLearnt) {
  Point dull = point_at({0, 0, 1}, 2);
  dull.doubtful = true;
  dull.light = 0.3f;
  for (int k = 0; k < 9; ++k) EXPECT_TRUE(frame({dull}).empty()) << k;
  EXPECT_EQ(frame({dull}).size(), 1u);
  for (int k = 0; k < 60; ++k) frame({dull});
  ASSERT_EQ(predictions_.size(), 1u);
  EXPECT_NEAR(predictions_[0].brightness, 0.3, 0.03);
}

TEST_F(TrackerTest, VelocityIsThatOfTheMarkerWhateverTheFrameTimes) {
  double x = 0;
  std::vector<TrackedPoint> out;
  for (int k = 0; k < 60; ++k) {
    const int frames = k % 7 == 3 ? 4 : 1;  // dropped exposures
    x += 5.0 * kDt * frames;
    out = frame({point_at({x, 0, 1})}, frames);
    ASSERT_EQ(out.size(), 1u);
  }
  EXPECT_EQ(counters_.started, 1u);
  EXPECT_NEAR(out[0].velocity_in_world.x(), 5.0, 0.1);
  EXPECT_LT(out[0].velocity_in_world.tail<2>().norm(), 0.05);
}

TEST_F(TrackerTest, CrossingTracksKeepTheirIds) {
  // Two markers pass within 2 mm of each other at 6 m/s each.
  std::vector<TrackedPoint> out;
  TrackId a{}, b{};
  for (int k = -30; k <= 30; ++k) {
    const double s = 6.0 * kDt * (k + 0.3);
    // Listed in an order that alternates, so that nothing hangs on it.
    std::vector<Point> points{point_at({s, 0.001, 1}), point_at({-s, -0.001, 1})};
    if (k % 2 == 0) std::swap(points[0], points[1]);
    out = frame(points);
    ASSERT_EQ(out.size(), 2u);
    for (const TrackedPoint& p : out) {
      const bool first = p.position_in_world.y() > 0;
      if (k == -30) (first ? a : b) = p.id;
      EXPECT_EQ(p.id, first ? a : b) << "frame " << k;
    }
  }
}

TEST_F(TrackerTest, ABounceKeepsTheIdWhenNobodyIsNear) {
  double x = 0, v = 10.0;
  TrackId id{};
  for (int k = 0; k < 80; ++k) {
    x += v * kDt;
    if (x > 1.5) {
      x = 3.0 - x;
      v = -v;
    }
    if (x < 0.0) {
      x = -x;
      v = -v;
    }
    // A second marker far away must not be disturbed.
    const auto& out = frame({point_at({0, -2, 1}), point_at({x, 0, 1})});
    ASSERT_EQ(out.size(), 2u);
    const TrackedPoint& moving = out[0].position_in_world.y() > -1 ? out[0] : out[1];
    if (k == 0) id = moving.id;
    EXPECT_EQ(moving.id, id) << "frame " << k;
  }
  EXPECT_EQ(counters_.started, 2u);
}

TEST_F(TrackerTest, ATrackSurvivesAShortGapAndNotALongOne) {
  const auto run_gap = [this](unsigned missed, double y) {
    TrackId before{}, after{};
    for (int k = 0; k < 20; ++k) before = frame({point_at({0.02 * k, y, 1})})[0].id;
    for (unsigned k = 0; k < missed; ++k)
      for (const TrackedPoint& point : frame({})) {
        EXPECT_EQ(point.kind, SampleKind::Predicted);
        EXPECT_EQ(point.age_frames, k + 1);
        EXPECT_EQ(point.id, before);
        EXPECT_NEAR(point.position_in_world.x(), 0.02 * (20.0 + k), 0.005);
      }
    after = frame({point_at({0.02 * (20.0 + missed), y, 1})})[0].id;
    return before == after;
  };
  EXPECT_TRUE(run_gap(options_.max_missed_frames, 0.0));
  EXPECT_FALSE(run_gap(options_.max_missed_frames + 1, 2.0));
  EXPECT_GE(counters_.ended, 1u);
}

TEST_F(TrackerTest, IdsAreNeverReused) {
  std::set<std::uint32_t> seen;
  for (int k = 0; k < 30; ++k) {
    const auto& out = frame({point_at({k % 2 == 0 ? 0.0 : 50.0, 0, 1})});
    ASSERT_EQ(out.size(), 1u);
    seen.insert(number(out[0].id));
    for (unsigned gap = 0; gap <= options_.max_missed_frames; ++gap) frame({});
  }
  EXPECT_EQ(seen.size(), 30u);
  EXPECT_EQ(seen.count(0u), 0u);
}

TEST_F(TrackerTest, PredictionsNameTheirTracksAndMoveOn) {
  for (int k = 0; k < 30; ++k) frame({point_at({0.03 * k, 0, 1})});
  now_ += kFrame;
  tracker_.predict(Timestamp(now_), predictions_);
  ASSERT_EQ(predictions_.size(), 1u);
  EXPECT_EQ(predictions_[0].track, tracked_[0].id);
  EXPECT_NEAR(predictions_[0].position_in_world.x(), 0.9, 1e-3);
  // The point carries the track: nearest or not, it is taken.
  std::vector<Point> points{point_at({0.9, 0, 1}), point_at({0.9005, 0, 1})};
  points[1].predicted_by = predictions_[0].track;
  tracker_.update(points, tracked_, counters_);
  ASSERT_EQ(tracked_.size(), 2u);
  EXPECT_EQ(tracked_[0].id, predictions_[0].track);
  EXPECT_NEAR(tracked_[0].position_in_world.x(), 0.9005, 3e-5);
}

TEST_F(TrackerTest, ExposuresOutOfOrderDoNoHarm) {
  for (int k = 0; k < 10; ++k) frame({point_at({0.05 * k, 0, 1})});
  EXPECT_EQ(frame({point_at({0.45, 0, 1})}, -3).size(), 1u);
  EXPECT_EQ(frame({point_at({0.45, 0, 1})}, 0).size(), 1u);
  EXPECT_EQ(counters_.started, 1u);
}

TEST(TrackOptions, SayWhatIsWrong) {
  TrackOptions options;
  std::vector<std::string> problems;
  options.check(problems);
  EXPECT_TRUE(problems.empty());
  options.acceleration_sd_m_s2 = 0;
  options.max_speed_m_s = -1;
  options.confirm_frames_two_views = 0;
  options.check(problems);
  EXPECT_EQ(problems.size(), 3u);
}

TEST_F(TrackerTest, TracksCoastThroughTheDark) {
  const auto position = [](int k) { return Eigen::Vector3d(0.05 * k, 0, 1); };
  TrackId id{};
  for (int k = 0; k < 600; ++k) {
    if (k % 10 == 7 || k % 10 == 8) {  // predicted, not updated
      now_ += kFrame;
      tracker_.predict(Timestamp(now_), predictions_);
      ASSERT_EQ(predictions_.size(), 1u);
      if (k > 20) {
        EXPECT_NEAR((predictions_[0].position_in_world - position(k)).norm(), 0.0, 1e-3);
      }
      continue;
    }
    const auto& out = frame({point_at(position(k))});
    ASSERT_EQ(out.size(), 1u);
    if (k == 0) id = out[0].id;
    EXPECT_EQ(out[0].id, id);
  }
  EXPECT_EQ(counters_.started, 1u);
  EXPECT_EQ(counters_.ended, 0u);
}

}  // namespace
}  // namespace glint
