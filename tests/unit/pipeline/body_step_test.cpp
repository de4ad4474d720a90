// SPDX-License-Identifier: MIT
// Blobs of moving bodies through matcher, tracker and bodies together.
#include <algorithm>
#include <chrono>
#include <cmath>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/pipeline/body_step.hpp"
#include "host/pipeline/track_step.hpp"
#include "tests/support/allocations.hpp"
#include "tests/unit/body/body_scene.hpp"

namespace glint {
namespace {

using namespace testing;
using ::testing::HasSubstr;

constexpr double kStep_s = 1.0 / 90;

std::vector<BodyModel> two_bodies() {
  std::mt19937_64 random(41);
  std::vector<BodyModel> models{random_body(random, 5, "one"), random_body(random, 5, "two")};
  for (BodyModel& model : models) model.marker_sd_m = 1e-5;
  return models;
}

/// Swings by 0.3 m and turns about a tilted axis.
Pose pose_at(std::size_t body, double time_s) {
  const double phase = static_cast<double>(body) * 2.0 + 4.0 * time_s;
  Pose pose;
  pose.rotation =
      Eigen::AngleAxisd(5.0 * time_s, Eigen::Vector3d(1, 2, static_cast<double>(body) - 1).normalized());
  pose.translation = {(body == 0 ? -0.6 : 0.6) + 0.3 * std::sin(phase), 0.3 * std::cos(phase),
                      0.8 + 0.2 * std::sin(1.7 * phase)};
  return pose;
}

Timestamp time_of(int frame) {
  return Timestamp{} + std::chrono::nanoseconds(static_cast<std::int64_t>(frame * kStep_s * 1e9));
}

class Stage {
 public:
  explicit Stage(std::vector<BodyModel> known) : step_(rig_, {}, {}, known) {}

  void take(int frame, double missing = 0.0, bool dark = false) {
    std::vector<Eigen::Vector3d> markers;
    for (std::size_t b = 0; b < models_.size(); ++b)
      for (const Eigen::Vector3d& p : models_[b].markers_in_body)
        markers.push_back(pose_at(b, frame * kStep_s) * p);
    const Exposure exposure =
        expose(rig_, dark ? std::vector<Eigen::Vector3d>() : markers, {0.05, missing, 0.0, 0}, random_);
    tick_.trigger = TriggerNo{static_cast<std::uint64_t>(frame)};
    tick_.exposed = time_of(frame);
    tick_.dark = dark;
    tick_.cameras.assign(exposure.blobs.begin(), exposure.blobs.end());
    step_.take(tick_);
    for (const BodyEvent& event : step_.body_events()) events.push_back(event);
  }
  const TrackStep& step() const { return step_; }

  std::vector<BodyEvent> events;

 private:
  const Calibration rig_ = ring_rig(4);
  const std::vector<BodyModel> models_ = two_bodies();
  std::mt19937_64 random_{42};
  TickBlobs tick_;
  TrackStep step_;
};

TEST(BodyStep, MakesPosesOfBlobs) {
  Stage stage(two_bodies());
  for (int frame = 0; frame < 120; ++frame) {
    stage.take(frame);
    if (frame < 10) continue;
    ASSERT_EQ(stage.step().bodies().size(), 2u) << "frame " << frame;
    for (const TrackedBody& body : stage.step().bodies()) {
      const Pose truth = pose_at(body.body, frame * kStep_s);
      EXPECT_LT((body.world_from_body.translation - truth.translation).norm(), 0.6e-3) << "frame " << frame;
      EXPECT_LT(body.world_from_body.rotation.angularDistance(truth.rotation), 0.01) << "frame " << frame;
      EXPECT_EQ(body.kind, BodyKind::Measured);
      EXPECT_GE(body.views, 15u) << "few of the cameras' views reach the fit";
    }
  }
  ASSERT_EQ(stage.events.size(), 2u);
  EXPECT_EQ(stage.events[0].kind, BodyEventKind::Found);
  EXPECT_EQ(stage.step().body_counters().found, 2u);
}

TEST(BodyStep, CoastsInTheDark) {
  Stage stage(two_bodies());
  for (int frame = 0; frame < 60; ++frame) {
    const bool dark = frame % 10 == 9;
    stage.take(frame, 0.0, dark);
    const std::size_t bodies = stage.step().bodies().size();
    if (dark) {
      EXPECT_TRUE(bodies == 0 && stage.step().body_events().empty());
    } else if (frame > 15) {
      EXPECT_EQ(bodies, 2u) << "frame " << frame;
    }
  }
  EXPECT_EQ(stage.step().body_counters().found, 2u);
  EXPECT_EQ(stage.step().body_counters().lost, 0u);
}

TEST(BodyStep, WithoutModelsThereAreNone) {
  Stage stage({});
  for (int frame = 0; frame < 20; ++frame) stage.take(frame);
  EXPECT_TRUE(stage.step().bodies().empty());
  EXPECT_FALSE(stage.step().tracked().empty());
}

/// A body that was followed for a while, and what tracks expect in the next frame.
class Advice : public ::testing::Test {
 protected:
  Advice() {
    cold_ = follow(0, 40, 0.0);
    tracker_.predict(time_of(40), predictions_);
  }
  /// Returns how often memory was asked for on behalf of bodies.
  std::size_t follow(int first, int end, double missing) {
    std::size_t allocated = 0;
    for (int frame = first; frame < end; ++frame) {
      const Exposure exposure = expose(rig_, markers_at(frame), {0.05, missing, 0.0, 0}, random_);
      std::vector<Prediction> predictions;
      tracker_.predict(time_of(frame), predictions);
      std::size_t before = allocations();
      bodies_.predict(time_of(frame), predictions);
      allocated += allocations() - before;
      matcher_.match(exposure.spans(), predictions, points_, match_counters_);
      tracker_.update(points_, tracked_, track_counters_);
      before = allocations();
      bodies_.update(points_, tracked_);
      allocated += allocations() - before;
    }
    return allocated;
  }
  std::vector<Eigen::Vector3d> markers_at(int frame) const {
    std::vector<Eigen::Vector3d> markers;
    for (const Eigen::Vector3d& p : models_[0].markers_in_body)
      markers.push_back(pose_at(0, frame * kStep_s) * p);
    return markers;
  }
  /// Distance to the nearest true marker.
  double off_m(const Eigen::Vector3d& at) const {
    double least = 1e9;
    for (const Eigen::Vector3d& marker : markers_at(40)) least = std::min(least, (marker - at).norm());
    return least;
  }

  const Calibration rig_ = ring_rig(4);
  const std::vector<BodyModel> models_{two_bodies()[0]};
  std::mt19937_64 random_{43};
  std::size_t cold_ = 0;
  Matcher matcher_{rig_, {}};
  Tracker tracker_{TrackOptions{}};
  BodyStep bodies_{rig_, {}, models_};
  std::vector<Point> points_;
  std::vector<TrackedPoint> tracked_;
  MatchCounters match_counters_;
  TrackCounters track_counters_;
  std::vector<Prediction> predictions_;
};

TEST_F(Advice, ReplacesAVaguePrediction) {
  ASSERT_EQ(predictions_.size(), 5u);
  for (Prediction& p : predictions_) {
    p.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
    p.position_in_world += Eigen::Vector3d(0.01, 0, 0);
    ASSERT_GT(p.mode_count, 0u);
  }
  bodies_.predict(time_of(40), predictions_);
  for (const Prediction& p : predictions_) {
    EXPECT_LT(off_m(p.position_in_world), 2e-3);
    EXPECT_LT(p.covariance_m2.trace(), 3e-5);
    EXPECT_EQ(p.mode_count, 0u);
    EXPECT_TRUE(p.bias.empty());
  }
}

TEST_F(Advice, LeavesASharpPredictionAlone) {
  ASSERT_EQ(predictions_.size(), 5u);
  std::vector<Prediction> before;
  for (Prediction& p : predictions_) {
    p.covariance_m2 = 1e-12 * Eigen::Matrix3d::Identity();
    before.push_back(p);
  }
  bodies_.predict(time_of(40), predictions_);
  for (std::size_t k = 0; k < before.size(); ++k) {
    EXPECT_EQ(predictions_[k].position_in_world, before[k].position_in_world);
    EXPECT_EQ(predictions_[k].mode_count, before[k].mode_count);
  }
}

TEST_F(Advice, ComesFromNoBodyThatIsNotSeen) {
  bodies_.predict(time_of(40), predictions_);
  bodies_.update({}, {});  // all markers hidden
  tracker_.update({}, tracked_, track_counters_);
  tracker_.predict(time_of(41), predictions_);
  ASSERT_EQ(predictions_.size(), 5u);
  for (Prediction& p : predictions_) p.covariance_m2 = Eigen::Matrix3d::Identity();
  bodies_.predict(time_of(41), predictions_);
  for (const Prediction& p : predictions_) EXPECT_EQ(p.covariance_m2, Eigen::Matrix3d::Identity());
}

TEST_F(Advice, AllocatesNothingOnceWarm) {
  EXPECT_GT(cold_, 0u) << "nothing was counted: the test shows nothing";
  follow(40, 100, 0.1);
  EXPECT_EQ(follow(100, 200, 0.1), 0u);
}

TEST(BodyStepOfAPlane, IsRefused) {
  MatchOptions match;
  match.plane_height_m = 0.0;
  try {
    BodyStep step(ring_rig(1), match, two_bodies());
    FAIL() << "not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("match.plane_height_m"));
  }
}

}  // namespace
}  // namespace glint
