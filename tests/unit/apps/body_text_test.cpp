// SPDX-License-Identifier: MIT
// Which bodies a run looks for, and what is said of them.
#include "host/apps/body_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "host/config/bodies_file.hpp"
#include "tests/support/temp_dir.hpp"

namespace glint::apps {
namespace {

using ::testing::HasSubstr;

BodyModel model(const std::string& name) { return {name, {{0, 0, 0}, {0.1, 0, 0}, {0, 0.07, 0}}, 1e-4}; }

std::string said(BodyEventKind kind, std::uint32_t other, BodyDoubt doubt = BodyDoubt::None) {
  const std::vector<BodyModel> bodies{model("drone"), model("cart")};
  return event_text(TriggerNo(12), {kind, 0, other, doubt}, bodies);
}

TEST(BodyText, SaysWhatHappened) {
  EXPECT_EQ(said(BodyEventKind::Found, 0), "tick 12: body drone found");
  EXPECT_EQ(said(BodyEventKind::Lost, 0), "tick 12: body drone lost");
  EXPECT_EQ(said(BodyEventKind::Ambiguous, 1, BodyDoubt::Crossing),
            "tick 12: body drone may be cart: they came too close");
  EXPECT_EQ(said(BodyEventKind::Ambiguous, 0, BodyDoubt::Symmetric),
            "tick 12: body drone may be turned otherwise: it looks the same when turned");
  EXPECT_EQ(said(BodyEventKind::Kept, 1), "tick 12: body drone is itself, and was all the time, not cart");
  EXPECT_EQ(said(BodyEventKind::Exchanged, 1),
            "tick 12: body drone had changed names with cart: right again");
}

TEST(ChosenBodies, AreTheRigsAndTheFilesAndElseTheScenes) {
  SimOptions options;
  options.motion = SimMotion::Tumbling;
  options.bodies.count = 2;
  options.markers = 10;
  const Scene scene(options);
  Rig rig;
  const std::vector<BodyModel> simulated = chosen_bodies(rig, {}, &scene);
  ASSERT_EQ(simulated.size(), 2u);
  EXPECT_EQ(simulated[1].name, "body2");
  EXPECT_EQ(simulated[1].markers_in_body, scene.body_markers(1));
  EXPECT_TRUE(chosen_bodies(rig, {}, nullptr).empty());

  const test::TempDir folder;
  const std::vector<std::filesystem::path> files{folder.path() / "cart.toml"};
  write_bodies(files[0], std::vector{model("cart")});
  rig.bodies = {model("drone")};
  const std::vector<BodyModel> both = chosen_bodies(rig, files, &scene);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].name + both[1].name, "dronecart");
  rig.bodies = {model("cart")};
  EXPECT_THROW(chosen_bodies(rig, files, &scene), Error) << "two of one name";
}

TEST(BodyRun, CountsExposuresAndTheLongestGap) {
  BodyRun run;
  run.bodies = {model("drone"), model("cart")};
  run.steadiness.resize(2);
  TrackedBody drone;
  TrackedBody hidden = drone;
  hidden.kind = BodyKind::Predicted;
  for (int k = 0; k < 3; ++k) run.add({});
  run.add(std::vector{drone});
  run.add(std::vector{hidden});
  run.add({});
  run.add(std::vector{drone});
  run.add({});
  EXPECT_EQ(run.exposures, 8u);
  EXPECT_EQ(run.steadiness[0].measured, 2u);
  EXPECT_EQ(run.steadiness[0].predicted, 1u);
  EXPECT_EQ(run.steadiness[0].longest_gap, 2u) << "before it was found is no gap";
  EXPECT_EQ(run.steadiness[1].longest_gap, 0u);
  const std::vector<ReportRow> rows = body_rows(run, {});
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].value, "25.000 % of exposures measured");
  EXPECT_EQ(rows[1].note, "never found");
  EXPECT_TRUE(body_rows({}, {}).empty());
}

}  // namespace
}  // namespace glint::apps
