// SPDX-License-Identifier: MIT
// What the watch over the cameras says.
#include "host/apps/health_text.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

namespace glint::apps {
namespace {

using ::testing::HasSubstr;

const std::vector<std::string> kNames{"left", "middle", "right"};
constexpr double kDegree = std::numbers::pi / 180.0;

CameraState bumped(double up, double right, double clockwise) {
  CameraState state;
  state.condition = CameraCondition::Bumped;
  state.turn_rad = kDegree * Eigen::Vector3d(up, right, clockwise);
  return state;
}

std::string said(const CameraState& state) { return event_text({CameraId{1}, state}, kNames); }

TEST(HealthText, NamesTheWayOfATurn) {
  EXPECT_EQ(
      said(bumped(0.02, 0.2, 0.0)),
      "camera middle was bumped: it looks 0.20 degrees to the right and 0.02 up of where it was calibrated; "
      "calibrate it anew: glint calibrate extrinsics ... --only middle");
  EXPECT_THAT(said(bumped(-0.3, -0.4, 0.001)),
              HasSubstr("looks 0.40 degrees to the left and 0.30 down of where it was calibrated;"));
  EXPECT_THAT(said(bumped(0.0, 0.0, -1.0)), HasSubstr("it is rolled by 1.00 degrees anticlockwise;"));
  EXPECT_THAT(
      said(bumped(0.5, 0.0, 0.5)),
      HasSubstr("looks 0.50 degrees up of where it was calibrated and is rolled by 0.50 degrees clockwise;"));
}

TEST(HealthText, NamesDelaysSwapsAndTheRest) {
  CameraState state;
  state.condition = CameraCondition::Late;
  state.late_s = 0.008;
  EXPECT_THAT(said(state), HasSubstr("camera middle exposes 8.0 ms later than the others"));
  state.late_s = -0.0123;
  EXPECT_THAT(said(state), HasSubstr("exposes 12.3 ms earlier than the others"));
  state.condition = CameraCondition::Swapped;
  state.swapped_with = CameraId{2};
  EXPECT_THAT(said(state), HasSubstr("camera middle shows what right should"));
  state.condition = CameraCondition::Drifting;
  EXPECT_THAT(said(state), HasSubstr("camera middle drifts"));
  state.condition = CameraCondition::Fine;
  EXPECT_EQ(said(state), "camera middle fits the others again");
}

TEST(HealthText, RowsAndJson) {
  HealthReport report;
  report.cameras.resize(3);
  report.cameras[0].state.condition = CameraCondition::Fine;
  report.cameras[0].compared = 100;
  report.cameras[0].agreed = 98;
  report.cameras[0].residual_px = 0.03;
  report.cameras[0].expected_px = 0.06;
  report.cameras[1].state = bumped(0.1, 0.2, 0.3);
  report.cameras[1].faults = 1;
  const std::vector<ReportRow> rows = health_rows(report, kNames);
  ASSERT_EQ(rows.size(), 3u);
  EXPECT_EQ(rows[0].name, "health of camera left");
  EXPECT_EQ(rows[0].value, "fine");
  EXPECT_THAT(rows[0].note, HasSubstr("98 of 100"));
  EXPECT_EQ(rows[2].value, "too little seen to tell");
  const nlohmann::ordered_json json = health_json(report, kNames);
  EXPECT_EQ(json[0]["condition"], "fine");
  EXPECT_EQ(json[0]["agreed"], 98);
  EXPECT_EQ(json[1]["condition"], "bumped");
  EXPECT_DOUBLE_EQ(json[1]["turn_rad"][1].get<double>(), 0.2 * kDegree);
  EXPECT_EQ(json[2]["condition"], "unknown");
  report.cameras.resize(2);
  EXPECT_TRUE(health_rows(report, kNames).empty()) << "two cameras cannot tell whose fault it is";
}

}  // namespace
}  // namespace glint::apps
