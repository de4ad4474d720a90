// SPDX-License-Identifier: MIT
// Bodies learnt from recordings, and why they cannot be.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/body/confusions.hpp"
#include "host/body/learn.hpp"
#include "tests/unit/body/body_scene.hpp"

namespace glint {
namespace {

using namespace testing;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

class Learn : public ::testing::Test {
 protected:
  /// Bodies that wander and turn, and two markers of nobody that wander alone.
  std::vector<RecordedTick> record(int frames, double speed, double missing = 0.0, double noise_m = 0.0003) {
    std::vector<RecordedTick> ticks;
    for (int frame = 0; frame < frames; ++frame) {
      RecordedTick& tick = ticks.emplace_back();
      std::uint32_t track = 1;
      for (std::size_t b = 0; b < models.size(); ++b) {
        const double t = speed * frame, a = static_cast<double>(b);
        Pose pose;
        pose.translation = {std::sin(0.05 * t + a), std::cos(0.037 * t + 2 * a),
                            0.8 + 0.3 * std::sin(0.02 * t + a)};
        pose.rotation = (rotation_of({0, 0, 0.03 * t}) * rotation_of({0.02 * t, a, 0})).normalized();
        for (const Eigen::Vector3d& marker : models[b].markers_in_body) {
          const TrackId id{track++ + (frame >= broken_at ? 1000u : 0u)};
          if (uniform(random, 0, 1) >= missing)
            tick.push_back({id, pose * marker + normal3(random, noise_m)});
        }
      }
      for (int k = 0; k < 2; ++k)
        tick.push_back(
            {TrackId{track++}, {std::cos(0.05 * frame + 2 * k), std::sin(0.09 * frame), 1.0 + 0.1 * k}});
    }
    return ticks;
  }
  /// Every model was learnt, whatever its frame and order.
  void expect_models(const Learnt& learnt, double within_m) {
    ASSERT_EQ(learnt.bodies.size(), models.size());
    for (const BodyModel& model : models) {
      bool known = false;
      for (const LearntBody& body : learnt.bodies) {
        const auto found = find_agreements(model.markers_in_body, body.model.markers_in_body, within_m);
        known = known || (!found.empty() && found[0].markers.size() == model.markers_in_body.size() &&
                          body.model.markers_in_body.size() == model.markers_in_body.size());
      }
      EXPECT_TRUE(known) << model.name;
    }
  }

  std::mt19937_64 random{41};
  std::vector<BodyModel> models{random_body(random, 6, "six"), random_body(random, 4, "four")};
  int broken_at = 1 << 30;  // frame from which on all tracks of bodies have other numbers
};

TEST_F(Learn, TwoBodiesAmongWanderers) {
  const Learnt learnt = learn_bodies(record(400, 1.0, 0.2));
  expect_models(learnt, 0.0002);
  EXPECT_EQ(learnt.bodies[0].model.name, "body1");
  EXPECT_NEAR(learnt.bodies[0].scatter_m, 0.0003, 0.00005);
  EXPECT_NEAR(learnt.bodies[0].model.marker_sd_m, 0.0003, 0.00005);
  EXPECT_GT(learnt.bodies[0].frames, 350u);
}

TEST_F(Learn, TheFrameIsAsItSays) {
  const Learnt learnt = learn_bodies(record(300, 1.0));
  for (const LearntBody& body : learnt.bodies) {
    const auto& m = body.model.markers_in_body;
    Eigen::Vector3d mean = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& p : m) {
      mean += p / static_cast<double>(m.size());
      EXPECT_LE(p.norm(), m[0].norm() + 1e-12);
    }
    EXPECT_LT(mean.norm(), 1e-12);
    EXPECT_NEAR(m[0].y(), 0.0, 1e-12);
    EXPECT_NEAR(m[0].z(), 0.0, 1e-12);
    EXPECT_GT(m[0].x(), 0.0);
    EXPECT_GT(m[1].y(), 0.0);
    EXPECT_NEAR(m[1].z(), 0.0, 1e-12);
  }
}

TEST_F(Learn, MarkersThatGotNewTracksAreStillOneMarker) {
  broken_at = 200;
  models.resize(1);
  auto ticks = record(400, 1.0);
  // One track lives on, and two others hold both halves together for a while.
  for (std::size_t k = 200; k < 400; ++k)
    for (RecordedSample& sample : ticks[k])
      if (number(sample.track) > 1000 &&
          (number(sample.track) <= 1003 || (k < 300 && number(sample.track) == 1004)))
        sample.track = TrackId{number(sample.track) - 1000};
  expect_models(learn_bodies(ticks), 0.0003);
}

TEST_F(Learn, SaysWhyItCannot) {
  EXPECT_THAT(learn_bodies(record(20, 1.0)).remarks, Contains(HasSubstr("only 20 frames")));
  const Learnt still = learn_bodies(record(200, 0.0));
  EXPECT_THAT(still.bodies, IsEmpty());
  EXPECT_THAT(still.remarks, Contains(HasSubstr("move and turn it")));
  EXPECT_THAT(learn_bodies(record(200, 1.0, 0.0, 0.01)).remarks, Contains(HasSubstr("nothing rigid")));
}

}  // namespace
}  // namespace glint
