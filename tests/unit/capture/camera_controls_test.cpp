// SPDX-License-Identifier: MIT
// Controls by name.
#include "host/capture/v4l2/camera_controls.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/capture/camera_stream_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::FakeControl;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::uint32_t kGain = 10, kAuto = 20, kExposure = 30, kMenu = 40, kFlip = 50;

class Controls : public ::testing::Test, protected test::StreamFixture {
 protected:
  Controls() : node_(driver_, path_.c_str()) {
    camera().controls = {{kGain, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 255, 5, 40, 40, {}, 0, 0, 0},
                         {kMenu,
                          V4L2_CTRL_TYPE_MENU,
                          "Trigger Mode",
                          0,
                          3,
                          1,
                          0,
                          0,
                          {"Free Running", "", "External Trigger", "Software"},
                          0,
                          0,
                          0},
                         {kExposure,
                          V4L2_CTRL_TYPE_INTEGER,
                          "Exposure Time, Absolute",
                          1,
                          5000,
                          1,
                          156,
                          156,
                          {},
                          V4L2_CTRL_FLAG_INACTIVE,
                          EACCES,
                          kAuto},
                         {kAuto,
                          V4L2_CTRL_TYPE_MENU,
                          "Auto Exposure",
                          0,
                          3,
                          1,
                          3,
                          3,
                          {"Auto Mode", "Manual Mode", "Shutter Priority", "Aperture Priority"},
                          0,
                          0,
                          0},
                         {kFlip, V4L2_CTRL_TYPE_BOOLEAN, "Horizontal Flip", 0, 1, 1, 0, 0, {}, 0, 0, 0}};
  }
  std::string set(const std::vector<ControlSetting>& settings) {
    return error_of([&] { set_controls(node_, settings); });
  }
  std::int64_t value(std::uint32_t id) {
    for (const FakeControl& control : camera().controls) {
      if (control.id == id) return control.value;
    }
    return -1;
  }
  DeviceNode node_;
};

TEST_F(Controls, Words) {
  EXPECT_EQ(control_word("Exposure Time, Absolute"), "exposure_time_absolute");
  EXPECT_EQ(control_word("  White Balance (auto) "), "white_balance_auto");
  EXPECT_EQ(control_word("gain"), "gain");
  EXPECT_EQ(control_word("??"), "");
}

TEST_F(Controls, AreListedWithRangesAndMenus) {
  const std::vector<CameraControl> all = list_controls(node_);
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[0].word, "gain");
  EXPECT_EQ(all[0].highest, 255);
  EXPECT_EQ(all[0].usual, 40);
  ASSERT_EQ(all[3].word, "trigger_mode");
  ASSERT_EQ(all[3].menu.size(), 3u) << "menus have gaps";
  EXPECT_EQ(all[3].menu[1].value, 2);
  EXPECT_EQ(all[3].menu[1].name, "External Trigger");
  EXPECT_TRUE(all[2].inactive);
}

TEST_F(Controls, NumbersNamesAndSwitches) {
  EXPECT_EQ(set({{"GAIN", 45}, {"trigger mode", std::string("external trigger")}, {"horizontal_flip", 1}}),
            "");
  EXPECT_EQ(value(kGain), 45);
  EXPECT_EQ(value(kMenu), 2);
  EXPECT_EQ(value(kFlip), 1);
  EXPECT_EQ(set({{"Trigger_Mode", 3}, {"horizontal_flip", std::string("false")}}), "");
  EXPECT_EQ(value(kMenu), 3);
  EXPECT_EQ(value(kFlip), 0);
}

TEST_F(Controls, OneThatAnotherMakesPossibleIsSetInTheEnd) {
  EXPECT_EQ(set({{"exposure_time_absolute", 12}, {"auto_exposure", std::string("Manual Mode")}}), "");
  EXPECT_EQ(value(kExposure), 12);
}

TEST_F(Controls, EveryProblemIsNamed) {
  const std::string problems = set({{"gian", 1},
                                    {"gain", 300},
                                    {"gain", 7},
                                    {"trigger_mode", 1},
                                    {"trigger_mode", std::string("hardware")},
                                    {"gain", std::string("high")},
                                    {"exposure_time_absolute", 12}});
  EXPECT_THAT(
      problems,
      AllOf(HasSubstr("control gian is unknown to this camera; it has: gain, auto_exposure"),
            HasSubstr("control gain must be 0 to 255 in steps of 5, not 300"),
            HasSubstr("control gain must be 0 to 255 in steps of 5, not 7"),
            HasSubstr("control trigger_mode must be one of 0 \"Free Running\", 2 \"External Trigger\""),
            HasSubstr("control gain must be a number"),
            HasSubstr("control exposure_time_absolute was refused: Permission denied; another control "
                      "makes it inactive")));
  EXPECT_EQ(std::count(problems.begin(), problems.end(), '\n'), 6);
}

TEST_F(Controls, AValueThatTheDriverChangesIsSaid) {
  for (FakeControl& control : camera().controls) {
    if (control.id == kGain) control.step = 1;
  }
  camera().answers[VIDIOC_S_EXT_CTRLS] = {0, ERANGE, ERANGE};
  EXPECT_EQ(set({{"gain", 41}}), "");
  EXPECT_THAT(set({{"gain", 42}}), HasSubstr("control gain was refused: Numerical result out of range"));
}

}  // namespace
}  // namespace glint
