// SPDX-License-Identifier: MIT
// Which bodies are refused, and which are told to be confusable.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/body/body_shapes.hpp"
#include "host/body/confusions.hpp"
#include "tests/unit/body/body_scene.hpp"

namespace glint {
namespace {

using namespace testing;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::vector<std::string> problems_of(const BodyModel& model) {
  std::vector<std::string> problems;
  model.check(problems);
  return problems;
}

const BodyModel kKite{"kite", {{0, 0, 0}, {0.1, 0, 0}, {0, 0.15, 0}, {0.03, 0.02, 0.06}}};

TEST(BodyModel, SoundOnesPass) { EXPECT_THAT(problems_of(kKite), IsEmpty()); }

TEST(BodyModel, SaysWhatIsWrong) {
  BodyModel model = kKite;
  model.markers_in_body.resize(2);
  EXPECT_THAT(problems_of(model), ElementsAre("body.markers_in_body_m must hold 3 to 32 markers, not 2"));
  model = kKite;
  model.markers_in_body[3] = {0.1, 0.005, 0};
  EXPECT_THAT(problems_of(model), ElementsAre(HasSubstr("markers 2 and 4 only 5.0 mm apart")));
  model.markers_in_body = {{0, 0, 0}, {0.1, 0, 0}, {0.2, 0.001, 0}};
  EXPECT_THAT(problems_of(model), ElementsAre(HasSubstr("lies on a line")));
  model.markers_in_body = {{0, 0, 0}, {100, 0, 0}, {0, 150, 0}};
  EXPECT_THAT(problems_of(model), ElementsAre(HasSubstr("it is in metres")));
  model = kKite;
  model.marker_sd_m = 0;
  model.name.clear();
  EXPECT_THAT(problems_of(model), ElementsAre(HasSubstr("name"), HasSubstr("marker_sd_m")));
}

TEST(BodyModel, NamesAreUnique) {
  const std::vector<BodyModel> models{kKite, kKite};
  try {
    check_bodies(models);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("body 2 (\"kite\"): body.name is also that of body 1"));
  }
}

TEST(Confusions, ASquareTurnedByNinetyDegrees) {
  const BodyModel square{"square",
                         {{0.05, 0.05, 0}, {-0.05, 0.05, 0}, {-0.05, -0.05, 0}, {0.05, -0.05, 0.0004}}};
  const auto found = find_confusions({&square, 1});
  ASSERT_FALSE(found.empty());
  // About its axis by 90 (its inverse is the same confusion) and 180 degrees, and four ways of turning it
  // over.
  int whole = 0, quarter = 0;
  for (const Confusion& c : found) {
    whole += c.whole ? 1 : 0;
    quarter += std::abs(c.turn_rad - M_PI / 2) < 0.02 ? 1 : 0;
  }
  EXPECT_EQ(whole, 6);
  EXPECT_EQ(quarter, 1);
  EXPECT_LT(found.front().agreement.difference_m, 0.0005);
  EXPECT_TRUE(sort_into_shapes({&square, 1}).symmetric[0]);
}

TEST(Confusions, OneMarkerAsideEndsIt) {
  const BodyModel body{"b", {{0.05, 0.05, 0}, {-0.05, 0.05, 0}, {-0.05, -0.05, 0}, {0.03, -0.07, 0.04}}};
  for (const Confusion& c : find_confusions({&body, 1})) EXPECT_FALSE(c.whole);
  EXPECT_FALSE(sort_into_shapes({&body, 1}).symmetric[0]);
}

TEST(Confusions, TwoBodiesThatShareAllButOneMarker) {
  BodyModel other = kKite;
  other.name = "other";
  other.markers_in_body[3] = {-0.05, 0.01, 0.03};
  // Wherever and in whatever order it was defined.
  std::mt19937_64 random(3);
  const Pose pose = random_pose(random);
  for (Eigen::Vector3d& p : other.markers_in_body) p = pose * p;
  std::swap(other.markers_in_body[0], other.markers_in_body[2]);
  const std::vector<BodyModel> models{kKite, other};
  const auto found = find_confusions(models);
  const auto both =
      std::find_if(found.begin(), found.end(), [](const Confusion& c) { return c.body != c.other; });
  ASSERT_NE(both, found.end());
  EXPECT_THAT(both->agreement.markers, ElementsAre(std::pair(0u, 2u), std::pair(1u, 1u), std::pair(2u, 0u)));
  EXPECT_TRUE(both->nearly);
  EXPECT_FALSE(both->whole);
  EXPECT_THAT(describe(*both, models), HasSubstr("\"kite\" can be taken for \"other\" by 3 of 4 markers"));
}

TEST(Shapes, IdenticalInAnyFrameAndOrderButNotMirrored) {
  std::mt19937_64 random(4);
  std::vector<BodyModel> models{random_body(random, 5, "a")};
  BodyModel moved = models[0], mirrored = models[0];
  moved.name = "b";
  mirrored.name = "c";
  const Pose pose = random_pose(random);
  for (Eigen::Vector3d& p : moved.markers_in_body) p = pose * p + normal3(random, 0.0003);
  std::rotate(moved.markers_in_body.begin(), moved.markers_in_body.begin() + 2, moved.markers_in_body.end());
  for (Eigen::Vector3d& p : mirrored.markers_in_body) p.z() = -p.z();
  models.push_back(moved);
  models.push_back(mirrored);
  const BodyShapes shapes = sort_into_shapes(models);
  EXPECT_EQ(shapes.bodies[1].shape, 0u);
  EXPECT_EQ(shapes.bodies[2].shape, 1u);
  EXPECT_THAT(shapes.members[0], ElementsAre(0u, 1u));
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_LT((shapes.bodies[1].markers_in_shape[k] - models[0].markers_in_body[k]).norm(), 0.002);
    const Eigen::Vector3d& own = moved.markers_in_body[shapes.bodies[1].own_marker[k]];
    EXPECT_LT((shapes.bodies[1].shape_from_body * own - shapes.bodies[1].markers_in_shape[k]).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace glint
