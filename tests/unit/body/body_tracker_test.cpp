// SPDX-License-Identifier: MIT
// Whole lives of bodies: found, followed, hidden, exchanged by their tracks, crossing, lost.
#include <algorithm>
#include <chrono>
#include <map>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/body/body_tracker.hpp"
#include "tests/support/allocations.hpp"
#include "tests/unit/body/body_scene.hpp"

namespace glint {
namespace {

using namespace testing;
using ::testing::HasSubstr;

constexpr double kStep_s = 1.0 / 90;

/// Bodies that move, and the samples of their markers.
class Stage {
 public:
  explicit Stage(std::vector<BodyModel> given, BodyTrackerOptions options = {})
      : models(given), tracker(std::move(given), options) {
    for (const BodyModel& model : models) {
      auto& markers = true_markers.emplace_back();
      for (const Eigen::Vector3d& p : model.markers_in_body)
        markers.push_back(p + normal3(random, model.marker_sd_m));
      tracks.emplace_back(markers.size());
      for (TrackId& track : tracks.back()) track = TrackId{next_track++};
      hidden.emplace_back(markers.size(), false);
    }
  }

  /// One exposure with the bodies at `poses`; `tracks` and `hidden` may be changed in between.
  void step(const std::vector<Pose>& poses, double sd_px = 0.1, double missing = 0.0) {
    now += std::chrono::nanoseconds(static_cast<std::int64_t>(kStep_s * 1e9));
    tracker.predict(now, expected);
    views.clear();
    samples.clear();
    views.reserve(1000);
    for (std::size_t b = 0; b < models.size(); ++b)
      for (std::size_t m = 0; m < true_markers[b].size(); ++m) {
        if (hidden[b][m]) continue;
        const std::size_t first = views.size();
        for (const Observation& view :
             observe(cameras, poses[b] * true_markers[b][m], sd_px, missing, random))
          views.push_back(view);
        const std::span<const Observation> mine(views.data() + first, views.size() - first);
        const auto point = triangulate(mine, {});
        if (!point) {
          views.resize(first);
          continue;
        }
        samples.push_back({tracks[b][m], point->position_in_world, point->covariance_m2, mine});
      }
    for (std::size_t k = 0; k < clutter; ++k) {
      const std::size_t first = views.size();
      const Eigen::Vector3d at(uniform(random, -1.2, 1.2), uniform(random, -1.2, 1.2),
                               uniform(random, 0.0, 1.6));
      for (const Observation& view : observe(cameras, at, sd_px, 0.0, random)) views.push_back(view);
      const std::span<const Observation> mine(views.data() + first, views.size() - first);
      if (const auto point = triangulate(mine, {}))
        samples.push_back({TrackId{next_track++}, point->position_in_world, point->covariance_m2, mine});
    }
    std::shuffle(samples.begin(), samples.end(), random);
    tracker.update(samples, bodies, counters);
    for (const BodyEvent& event : tracker.events()) events.push_back(event);
    truth = poses;
  }
  const TrackedBody* shown(std::uint32_t body) const {
    const auto found =
        std::find_if(bodies.begin(), bodies.end(), [body](const TrackedBody& b) { return b.body == body; });
    return found == bodies.end() ? nullptr : &*found;
  }
  Vector6 error(std::uint32_t body) const {
    return pose_difference(shown(body)->world_from_body, truth[body]);
  }
  void renew_tracks(std::size_t body) {
    for (TrackId& track : tracks[body]) track = TrackId{next_track++};
  }
  int told(BodyEventKind kind) const {
    return static_cast<int>(
        std::count_if(events.begin(), events.end(), [kind](const BodyEvent& e) { return e.kind == kind; }));
  }

  std::mt19937_64 random{21};
  std::vector<Camera> cameras = cameras_of(ring_rig(4));
  std::vector<BodyModel> models;
  std::vector<std::vector<Eigen::Vector3d>> true_markers;
  std::vector<std::vector<TrackId>> tracks;
  std::vector<std::vector<bool>> hidden;
  std::size_t clutter = 0;  ///< points of nobody, each frame others
  BodyTracker tracker;
  std::uint32_t next_track = 1;
  Timestamp now{};
  std::vector<ExpectedMarker> expected;
  std::vector<Observation> views;
  std::vector<MarkerSample> samples;
  std::vector<TrackedBody> bodies;
  BodyCounters counters;
  std::vector<BodyEvent> events;
  std::vector<Pose> truth;
};

std::vector<BodyModel> different(std::size_t count, std::size_t markers = 5) {
  std::mt19937_64 random(31);
  std::vector<BodyModel> models;
  for (std::size_t k = 0; k < count; ++k)
    models.push_back(random_body(random, markers, "b" + std::to_string(k)));
  return models;
}

/// The same shape in other frames and with other numbers.
std::vector<BodyModel> identical(std::size_t count) {
  std::mt19937_64 random(32);
  std::vector<BodyModel> models{random_body(random, 5, "i0")};
  for (std::size_t k = 1; k < count; ++k) {
    BodyModel other = models[0];
    other.name = "i" + std::to_string(k);
    const Pose pose = random_pose(random);
    for (Eigen::Vector3d& p : other.markers_in_body) p = pose * p - pose.translation;
    std::rotate(other.markers_in_body.begin(), other.markers_in_body.begin() + static_cast<std::ptrdiff_t>(k),
                other.markers_in_body.end());
    models.push_back(other);
  }
  return models;
}

/// Bodies k of n on their ways through the volume, at up to 4 m/s and 8 rad/s.
std::vector<Pose> flying(std::size_t count, double t) {
  std::vector<Pose> poses;
  for (std::size_t k = 0; k < count; ++k) {
    const double a = static_cast<double>(k);
    Pose pose;
    pose.translation = {0.9 * std::sin(4.0 * t + 2.1 * a), 0.8 * std::cos(3.1 * t + 1.3 * a * a),
                        0.8 + 0.5 * std::sin(2.3 * t + a)};
    pose.rotation = (rotation_of({0, 0, 5.0 * t + a}) * rotation_of({3.0 * t, a, 0})).normalized();
    poses.push_back(pose);
  }
  return poses;
}

TEST(BodyTracker, RefusesWhatCannotBeTracked) {
  try {
    BodyTracker tracker({{"rod", {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0, 0}}}});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("body 1 (\"rod\"): body.markers_in_body_m lies on a line"));
  }
}

TEST(BodyTracker, FindsFollowsAndIsHonest) {
  Stage stage(different(8));
  double nees = 0.0, worst = 0.0;
  int count = 0, missed = 0;
  for (int frame = 0; frame < 400; ++frame) {
    stage.step(flying(8, frame * kStep_s), 0.1, 0.2);
    for (std::uint32_t b = 0; b < 8; ++b) {
      const TrackedBody* body = stage.shown(b);
      if (frame < 5) continue;
      if (body == nullptr || body->kind != BodyKind::Measured) {
        ++missed;
        continue;
      }
      const Vector6 e = stage.error(b);
      nees += e.dot(body->covariance.inverse() * e);
      worst = std::max(worst, e.tail<3>().norm());
      ++count;
    }
  }
  std::printf("8 bodies, 20 %% of views missing: NEES %.2f of 6, worst %.2f mm, %d of %d frames without\n",
              nees / count, 1e3 * worst, missed, count + missed);
  EXPECT_EQ(missed, 0);
  EXPECT_LT(worst, 0.003);
  // A marker's error in the model stays the same, so that errors of one body are alike in all frames: the
  // mean is of 8 bodies rather than of 3,000 independent ones.
  EXPECT_GT(nees / count, 3.0);
  EXPECT_LT(nees / count, 10.0);
  EXPECT_EQ(stage.counters.found, 8u);
  EXPECT_EQ(stage.counters.lost, 0u);
}

TEST(BodyTracker, IsNeverFarOffWhateverTheTracksDo) {
  // Tracks end and begin anew, exchange their markers, markers are hidden for a while, and there is clutter.
  Stage stage(different(8));
  stage.clutter = 20;
  std::mt19937_64& random = stage.random;
  double worst = 0.0;
  int shown = 0, expected = 0, far = 0;
  std::vector<std::vector<int>> until(8, std::vector<int>(5, 0));
  for (int frame = 0; frame < 900; ++frame) {
    for (std::size_t b = 0; b < 8; ++b)
      for (std::size_t m = 0; m < 5; ++m) {
        if (uniform(random, 0, 1) < 0.01) stage.tracks[b][m] = TrackId{stage.next_track++};
        if (uniform(random, 0, 1) < 0.002) std::swap(stage.tracks[b][m], stage.tracks[b][(m + 1) % 5]);
        if (uniform(random, 0, 1) < 0.002)
          std::swap(stage.tracks[b][m], stage.tracks[(b + 1) % 8][static_cast<std::size_t>(random() % 5)]);
        if (uniform(random, 0, 1) < 0.02) until[b][m] = frame + static_cast<int>(random() % 30);
        stage.hidden[b][m] = frame < until[b][m];
      }
    stage.step(flying(8, frame * kStep_s), 0.1, 0.1);
    for (std::uint32_t b = 0; b < 8 && frame >= 10; ++b) {
      const auto hidden = std::count(stage.hidden[b].begin(), stage.hidden[b].end(), true);
      if (hidden <= 2) ++expected;
      const TrackedBody* body = stage.shown(b);
      if (body == nullptr) continue;
      if (hidden <= 2 && body->kind == BodyKind::Measured) ++shown;
      const double off = stage.error(b).tail<3>().norm();
      const double sd = std::sqrt(body->covariance.bottomRightCorner<3, 3>().trace());
      if (body->kind == BodyKind::Measured && !body->ambiguous) worst = std::max(worst, off);
      far += off > 0.003 && off > 5.0 * sd && !body->ambiguous ? 1 : 0;
    }
  }
  std::printf(
      "troubled tracks: %d of %d frames with three markers measured, worst %.1f mm, %d far off, %llu let go, "
      "%llu acquired, %llu contested, %llu lost, %llu jumps\n",
      shown, expected, 1e3 * worst, far, static_cast<unsigned long long>(stage.counters.let_go),
      static_cast<unsigned long long>(stage.counters.acquired),
      static_cast<unsigned long long>(stage.counters.contested),
      static_cast<unsigned long long>(stage.counters.lost),
      static_cast<unsigned long long>(stage.counters.jumps));
  // A body found anew by three of its markers is shown after three frames.
  EXPECT_GE(shown, expected * 97 / 100);
  EXPECT_EQ(far, 0);
}

TEST(BodyTracker, ExpectsItsMarkersWhereTheyAre) {
  Stage stage(different(1));
  double chi2 = 0.0;
  int count = 0;
  for (int frame = 0; frame < 200; ++frame) {
    stage.step(flying(1, frame * kStep_s));
    if (frame < 10) continue;
    ASSERT_EQ(stage.expected.size(), 5u);
    for (const ExpectedMarker& e : stage.expected) {
      EXPECT_EQ(e.track, stage.tracks[0][e.marker]);
      const Eigen::Vector3d r = stage.truth[0] * stage.true_markers[0][e.marker] - e.position_in_world;
      chi2 += r.dot(e.covariance_m2.inverse() * r);
      ++count;
    }
  }
  EXPECT_LT(chi2 / count, 3.5);
  EXPECT_GT(chi2 / count, 0.1);
}

TEST(BodyTracker, GoesOnWithTwoMarkersAndTakesTheOthersBack) {
  Stage stage(different(2));
  int frame = 0;
  const auto run = [&](int frames) {
    for (int k = 0; k < frames; ++k) stage.step(flying(2, frame++ * kStep_s));
  };
  run(20);
  stage.hidden[0] = {false, true, true, false, true};
  run(4);
  ASSERT_NE(stage.shown(0), nullptr);
  EXPECT_EQ(stage.shown(0)->kind, BodyKind::Measured);
  EXPECT_EQ(stage.shown(0)->markers, 2u);
  EXPECT_LT(stage.error(0).tail<3>().norm(), 0.03);
  stage.hidden[0].assign(5, false);
  for (const std::size_t m : {1u, 2u, 4u}) stage.tracks[0][m] = TrackId{stage.next_track++};
  run(3);
  EXPECT_EQ(stage.shown(0)->markers, 5u);
  EXPECT_LT(stage.error(0).tail<3>().norm(), 0.002);
  EXPECT_EQ(stage.counters.lost, 0u);
}

TEST(BodyTracker, LetsGoOfATrackThatWentAstray) {
  Stage stage(different(2));
  for (int frame = 0; frame < 20; ++frame) stage.step(flying(2, frame * kStep_s));
  // Two markers of different bodies exchange their tracks.
  std::swap(stage.tracks[0][1], stage.tracks[1][3]);
  stage.step(flying(2, 20 * kStep_s));
  EXPECT_EQ(stage.counters.let_go, 2u);
  for (std::uint32_t b = 0; b < 2; ++b) {
    EXPECT_EQ(stage.shown(b)->markers, 5u) << "taken back by their places at once";
    EXPECT_LT(stage.error(b).tail<3>().norm(), 0.002);
  }
}

TEST(BodyTracker, IsPredictedWhileHiddenThenLostThenFoundAgain) {
  Stage stage(different(1));
  int frame = 0;
  for (; frame < 20; ++frame) stage.step(flying(1, frame * kStep_s));
  stage.hidden[0].assign(5, true);
  stage.step(flying(1, frame++ * kStep_s));
  stage.step(flying(1, frame++ * kStep_s));
  ASSERT_NE(stage.shown(0), nullptr);
  EXPECT_EQ(stage.shown(0)->kind, BodyKind::Predicted);
  EXPECT_EQ(stage.shown(0)->age_frames, 2u);
  for (int k = 0; k < 60; ++k) stage.step(flying(1, frame++ * kStep_s));
  EXPECT_EQ(stage.shown(0), nullptr);
  EXPECT_EQ(stage.told(BodyEventKind::Lost), 1);
  stage.hidden[0].assign(5, false);
  stage.renew_tracks(0);
  stage.step(flying(1, frame++ * kStep_s));
  ASSERT_NE(stage.shown(0), nullptr);
  EXPECT_EQ(stage.told(BodyEventKind::Found), 2);
  EXPECT_FALSE(stage.shown(0)->ambiguous);
  EXPECT_LT(stage.error(0).tail<3>().norm(), 0.002);
}

TEST(BodyTracker, ABlowIsABeginning) {
  Stage stage(different(1));
  Pose pose;
  pose.translation = {0, 0, 0.8};
  for (int frame = 0; frame < 60; ++frame) {
    pose.translation.x() += (frame < 30 ? 8.0 : -8.0) * kStep_s;
    if (frame == 30) pose.translation.x() += 0.03;
    Pose at = pose;
    at.translation.x() = std::clamp(at.translation.x() - 1.3, -1.5, 1.5);
    stage.step({at});
    if (frame >= 3) {
      ASSERT_NE(stage.shown(0), nullptr) << frame;
      EXPECT_EQ(stage.shown(0)->markers, 5u) << frame;
      EXPECT_LT(stage.error(0).tail<3>().norm(), 0.002) << frame;
    }
  }
  EXPECT_EQ(stage.counters.lost, 0u);
  EXPECT_GE(stage.counters.jumps, 1u);
}

/// Two identical bodies whose centres pass at 5 cm, turning.
std::vector<Pose> crossing(double t, double closest_m) {
  std::vector<Pose> poses(2);
  for (int k = 0; k < 2; ++k) {
    const double side = k == 0 ? 1.0 : -1.0;
    poses[static_cast<std::size_t>(k)].translation = {
        side * 0.6 * std::sin(2 * M_PI * t), side * 0.5 * closest_m,
        0.9 + side * 0.2 * std::sin(2 * M_PI * t) * std::sin(0.37 * t)};
    poses[static_cast<std::size_t>(k)].rotation =
        (rotation_of({0, 0, side * 4.0 * t}) * rotation_of({2.0 * t, side, 0})).normalized();
  }
  return poses;
}

TEST(BodyTracker, IdenticalBodiesCross) {
  // Centres 22 cm apart leave 2 cm and more between markers of balls of 20 cm.
  Stage stage(identical(2));
  int ambiguous = 0, swapped = 0, shown = 0;
  for (int frame = 0; frame < 900; ++frame) {
    stage.step(crossing(0.25 + frame * kStep_s, 0.22), 0.1, 0.1);
    for (std::uint32_t b = 0; b < 2; ++b) {
      const TrackedBody* body = stage.shown(b);
      if (body == nullptr) continue;
      ++shown;
      ambiguous += body->ambiguous ? 1 : 0;
      // The names are given out when both are first seen; from then on they must stay.
      const double own = (body->world_from_body.translation - stage.truth[b].translation).norm();
      const double other = (body->world_from_body.translation - stage.truth[1 - b].translation).norm();
      swapped += other < own ? 1 : 0;
    }
  }
  EXPECT_GE(shown, 2 * 895);
  EXPECT_TRUE(swapped == 0 || swapped == shown) << swapped << " of " << shown;
  EXPECT_EQ(ambiguous, 0);
}

TEST(BodyTracker, MeetingInOnePlaceIsAmbiguousAndIsResolved) {
  // They go through each other at 4 m/s.
  int ambiguous = 0, kept = 0, wrong = 0;
  for (int run = 0; run < 20; ++run) {
    Stage stage(identical(2));
    stage.random.seed(static_cast<std::uint64_t>(run));
    bool other_way = false;
    for (int frame = 0; frame < 90; ++frame) {
      const double t = (frame - 45) * kStep_s;
      std::vector<Pose> poses(2);
      poses[0].translation = {2.0 * t, 0.0005, 0.8};
      poses[1].translation = {-2.0 * t, -0.0005, 0.8};
      // None is seen while they pass, and their tracks are all new afterwards.
      const bool dim = frame > 41 && frame < 50;
      for (std::size_t b = 0; b < 2; ++b) {
        stage.hidden[b].assign(5, dim);
        if (frame == 50) stage.renew_tracks(b);
      }
      stage.step(poses);
      for (const TrackedBody& body : stage.bodies) {
        if (frame == 20 && body.body == 0)
          other_way = (body.world_from_body.translation - poses[0].translation).norm() >
                      (body.world_from_body.translation - poses[1].translation).norm();
        const std::size_t truly = other_way ? 1 - body.body : body.body;
        wrong += !body.ambiguous && frame > 20 && frame != 45 &&
                         (body.world_from_body.translation - poses[truly].translation).norm() >
                             (body.world_from_body.translation - poses[1 - truly].translation).norm() + 0.02
                     ? 1
                     : 0;
      }
    }
    ambiguous += stage.told(BodyEventKind::Ambiguous) > 0 ? 1 : 0;
    kept += stage.told(BodyEventKind::Kept) + stage.told(BodyEventKind::Exchanged) > 0 ? 1 : 0;
  }
  std::printf(
      "hidden in one place: ambiguous in %d of 20 runs, resolved in %d, silently wrong in %d frames\n",
      ambiguous, kept, wrong);
  EXPECT_EQ(wrong, 0);
}

TEST(BodyTracker, TracksThatGoOverToAnIdenticalBodyDoNotTakeItsNameAlong) {
  Stage stage(identical(2));
  const auto pose = [](int frame) { return crossing(0.25 + frame * kStep_s, 0.22); };
  for (int frame = 0; frame < 20; ++frame) stage.step(pose(frame));
  const bool other_way =
      (stage.shown(0)->world_from_body.translation - stage.truth[0].translation).norm() > 0.2;
  // All of them at once, marker by marker: the second body's numbers begin with the first one's second.
  for (std::size_t m = 0; m < 5; ++m) std::swap(stage.tracks[0][(m + 1) % 5], stage.tracks[1][m]);
  for (int frame = 20; frame < 40; ++frame) {
    stage.step(pose(frame));
    for (std::uint32_t b = 0; b < 2; ++b) {
      ASSERT_NE(stage.shown(b), nullptr);
      EXPECT_FALSE(stage.shown(b)->ambiguous);
      const auto& own = stage.truth[other_way ? 1 - b : b].translation;
      EXPECT_LT((stage.shown(b)->world_from_body.translation - own).norm(), 0.01) << frame;
    }
  }
}

TEST(BodyTracker, LostSideBySideTheyAreAmbiguousUntilAPersonSettlesIt) {
  Stage stage(identical(2));
  std::vector<Pose> poses(2);
  poses[0].translation = {-0.15, 0, 0.8};
  poses[1].translation = {0.15, 0, 0.8};
  for (int frame = 0; frame < 20; ++frame) stage.step(poses);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_FALSE(stage.shown(static_cast<std::uint32_t>(b))->ambiguous)
        << "names that nobody has borne are given";
    stage.hidden[b].assign(5, true);
  }
  for (int frame = 0; frame < 90; ++frame) stage.step(poses);
  EXPECT_TRUE(stage.bodies.empty());
  for (std::size_t b = 0; b < 2; ++b) {
    stage.hidden[b].assign(5, false);
    stage.renew_tracks(b);
  }
  for (int frame = 0; frame < 20; ++frame) stage.step(poses);
  for (std::uint32_t b = 0; b < 2; ++b) {
    ASSERT_NE(stage.shown(b), nullptr);
    EXPECT_TRUE(stage.shown(b)->ambiguous);
    EXPECT_EQ(stage.shown(b)->ambiguous_with, 1 - b);
    EXPECT_EQ(stage.shown(b)->doubt, BodyDoubt::FoundAgain);
  }
  EXPECT_EQ(stage.told(BodyEventKind::Ambiguous), 2);
  stage.tracker.settle(0);
  stage.step(poses);
  EXPECT_FALSE(stage.shown(0)->ambiguous);
  EXPECT_FALSE(stage.shown(1)->ambiguous);
}

TEST(BodyTracker, LostFarApartTheyAreThemselves) {
  Stage stage(identical(2));
  std::vector<Pose> poses(2);
  poses[0].translation = {-0.9, 0, 0.8};
  poses[1].translation = {0.9, 0, 0.8};
  for (int frame = 0; frame < 20; ++frame) stage.step(poses);
  for (std::size_t b = 0; b < 2; ++b) stage.hidden[b].assign(5, true);
  const Eigen::Vector3d before = stage.shown(0)->world_from_body.translation;
  for (int frame = 0; frame < 15; ++frame) stage.step(poses);
  for (std::size_t b = 0; b < 2; ++b) {
    stage.hidden[b].assign(5, false);
    stage.renew_tracks(b);
  }
  for (int frame = 0; frame < 5; ++frame) stage.step(poses);
  ASSERT_NE(stage.shown(0), nullptr);
  EXPECT_FALSE(stage.shown(0)->ambiguous);
  EXPECT_LT((stage.shown(0)->world_from_body.translation - before).norm(), 0.01);
}

TEST(BodyTracker, BothHiddenWhileTheyPassEachOtherAreNeverExchangedSilently) {
  // Hidden for 3 to 9 frames around the crossing; afterwards all tracks are new.
  int ambiguous_runs = 0, wrong = 0, settled = 0;
  const int runs = 40;
  for (int run = 0; run < runs; ++run) {
    Stage stage(identical(2));
    stage.random.seed(static_cast<std::uint64_t>(run));
    const int gap = 3 + run % 7;
    const auto pose = [&](int frame) { return crossing(0.25 + 0.5 * run + frame * kStep_s, 0.05); };
    const int middle = static_cast<int>(0.25 / kStep_s);
    int frame = 0;
    for (; frame < middle - gap / 2; ++frame) stage.step(pose(frame));
    const bool other_way = (stage.shown(0)->world_from_body.translation - stage.truth[0].translation).norm() >
                           (stage.shown(0)->world_from_body.translation - stage.truth[1].translation).norm();
    for (std::size_t b = 0; b < 2; ++b) stage.hidden[b].assign(5, true);
    for (int k = 0; k < gap; ++k) stage.step(pose(frame++));
    for (std::size_t b = 0; b < 2; ++b) {
      stage.hidden[b].assign(5, false);
      stage.renew_tracks(b);
    }
    bool was_ambiguous = false;
    for (int k = 0; k < 30; ++k) {
      stage.step(pose(frame++));
      for (const TrackedBody& body : stage.bodies) {
        was_ambiguous = was_ambiguous || body.ambiguous;
        const std::uint32_t truly = other_way ? 1 - body.body : body.body;
        const double own = (body.world_from_body.translation - stage.truth[truly].translation).norm();
        const double other = (body.world_from_body.translation - stage.truth[1 - truly].translation).norm();
        if (other < own && !body.ambiguous) ++wrong;
      }
    }
    ambiguous_runs += was_ambiguous ? 1 : 0;
    settled += was_ambiguous && !stage.bodies.empty() && !stage.bodies[0].ambiguous ? 1 : 0;
  }
  std::printf(
      "hidden crossings: ambiguous in %d runs, resolved in %d, silent frames under the wrong name %d\n",
      ambiguous_runs, settled, wrong);
  EXPECT_EQ(wrong, 0);
}

TEST(BodyTracker, ASymmetricBodySaysSo) {
  Stage stage({{"square", {{0.05, 0.05, 0}, {-0.05, 0.05, 0}, {-0.05, -0.05, 0}, {0.05, -0.05, 0}}}});
  for (int frame = 0; frame < 5; ++frame) stage.step(flying(1, frame * kStep_s));
  ASSERT_NE(stage.shown(0), nullptr);
  EXPECT_TRUE(stage.shown(0)->ambiguous);
  EXPECT_EQ(stage.shown(0)->doubt, BodyDoubt::Symmetric);
}

TEST(BodyTracker, DoesNotAllocateOnceWarm) {
  Stage stage(different(8));
  std::vector<std::vector<MarkerSample>> frames;
  std::vector<std::vector<Observation>> views;
  const auto go = [&](int frame) {
    // There and back, so that the second half is no harder than the first.
    stage.step(flying(8, 0.3 * std::sin(frame * 0.05)), 0.1, 0.1);
    stage.hidden[frame % 8 == 0 ? 1 : 2][static_cast<std::size_t>(frame % 5)] = frame % 3 == 0;
  };
  for (int frame = 0; frame < 200; ++frame) go(frame);
  std::size_t allocated = 0;
  double seconds = 0.0;
  for (int frame = 200; frame < 400; ++frame) {
    // As step() does, but counting only what the tracker allocates.
    go(frame);
    const std::vector<MarkerSample> samples = stage.samples;
    const std::size_t before = glint::testing::allocations();
    const auto begin = std::chrono::steady_clock::now();
    stage.tracker.predict(stage.now, stage.expected);
    stage.tracker.update(samples, stage.bodies, stage.counters);
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    allocated += glint::testing::allocations() - before;
  }
  std::printf("8 bodies of 5 markers: %.0f us an exposure\n", seconds / 200 * 1e6);
  EXPECT_GT(glint::testing::allocations(), 0u);
  EXPECT_EQ(allocated, 0u);
  EXPECT_EQ(stage.bodies.size(), 8u);
}

}  // namespace
}  // namespace glint
