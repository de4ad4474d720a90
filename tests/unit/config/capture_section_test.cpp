// SPDX-License-Identifier: MIT
// Live cameras in rig files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/config/rig.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::TempFolder;
using ::testing::HasSubstr;

/// Lines 1 to 7.
constexpr const char* kRig =
    "format = 1\nkind = \"rig\"\n\n[rig]\nname = \"lab\"\nrate_hz = 90\ncalibration = \"cal.toml\"\n";

class CaptureSection : public ::testing::Test {
 protected:
  CaptureSection() {
    Calibration calibration;
    for (const char* name : {"north", "south"}) {
      CameraCalibration camera;
      camera.name = name;
      camera.width_px = 1280;
      camera.height_px = 800;
      calibration.cameras.push_back(camera);
    }
    write_calibration(folder_ / "cal.toml", calibration);
  }
  Rig read(const std::string& text) { return read_rig(folder_.write("rig.toml", kRig + text)); }
  std::string complaint(const std::string& text) {
    return folder_.strip(error_of([&] { read(text); }));
  }
  TempFolder folder_;
};

constexpr const char* kFull = R"([capture]
format = "mjpeg"
rate_hz = 120
deadline_ms = 3.5
[capture.controls]
trigger_mode = "External Trigger"
auto_exposure = 1
a_switch = true
[[capture.camera]]
name = "south"
device = "usb:1-2"
controls = { gain = 7 }
[[capture.camera]]
name = "north"
device = "serial:A1"
)";

TEST_F(CaptureSection, EveryKeyReachesItsField) {
  const CaptureSettings capture = read(kFull).capture;
  EXPECT_EQ(capture.format, "mjpeg");
  EXPECT_EQ(capture.rate_hz, 120.0);
  EXPECT_EQ(capture.deadline_ms, 3.5);
  ASSERT_EQ(capture.controls.size(), 3u);
  EXPECT_EQ(capture.controls[0].name, "trigger_mode") << "in the order of the file";
  EXPECT_EQ(std::get<std::string>(capture.controls[0].value), "External Trigger");
  EXPECT_EQ(std::get<std::int64_t>(capture.controls[1].value), 1);
  EXPECT_EQ(std::get<std::int64_t>(capture.controls[2].value), 1);
  ASSERT_EQ(capture.cameras.size(), 2u);
  EXPECT_EQ(capture.cameras[0].name, "south");
  EXPECT_EQ(capture.cameras[0].device, "usb:1-2");
  ASSERT_EQ(capture.cameras[0].controls.size(), 1u);
  EXPECT_EQ(capture.cameras[0].controls[0].name, "gain");
  EXPECT_EQ(capture.cameras[1].device, "serial:A1");
}

TEST_F(CaptureSection, DefaultsWithoutIt) {
  const CaptureSettings capture = read("").capture;
  EXPECT_EQ(capture.format, "auto");
  EXPECT_EQ(capture.rate_hz, 0.0);
  EXPECT_TRUE(capture.cameras.empty());
  std::vector<std::string> problems;
  capture.check(problems);
  EXPECT_THAT(problems, ::testing::IsEmpty());
}

TEST_F(CaptureSection, WhatShowPrintsReadsBackTheSame) {
  const Rig rig = read(kFull);
  const TempFolder elsewhere;
  const Rig again = read_rig(elsewhere.write("shown.toml", to_toml(rig)));
  EXPECT_EQ(to_toml(again), to_toml(rig));
  EXPECT_EQ(again.capture.cameras[0].controls[0].name, "gain");
  EXPECT_EQ(again.capture.controls[0].name, "trigger_mode");
}

TEST_F(CaptureSection, EveryProblemIsListedWithItsPlace) {
  EXPECT_EQ(
      complaint(R"([capture]
format = "h264"
rate_hz = -1
deadline_ms = 5000
controls = { gain = 1.5 }
[[capture.camera]]
name = "west"
device = "usb:1-2"
[[capture.camera]]
name = "north"
device = ""
gain = 3
[[capture.camera]]
name = "north"
device = "usb:1-2"
)"),
      "rig.toml:9:10: capture.format must be \"auto\", \"grey\", \"nv12\", \"yuyv\" or \"mjpeg\", not "
      "\"h264\"\n"
      "rig.toml:10:11: capture.rate_hz must be 0 (that of the rig) to 10000, not -1\n"
      "rig.toml:11:15: capture.deadline_ms must be 0 (half a period) to 1000, not 5000\n"
      "rig.toml:12:21: capture.controls.gain must be a whole number, true or false, or a menu's item in "
      "quotes\n"
      "rig.toml:14:8: capture.camera 1.name \"west\" is no camera of the calibration, which has: north, "
      "south\n"
      "rig.toml:18:10: capture.camera 2.device must not be empty (glint devices lists what there is)\n"
      "rig.toml:19:1: unknown key \"capture.camera 2.gain\"\n"
      "rig.toml:21:8: capture.camera 3.name \"north\" stands here twice\n"
      "rig.toml:22:10: capture.camera 3.device \"usb:1-2\" is another camera's already");
}

TEST_F(CaptureSection, MissingKeysAndMistypedOnes) {
  const std::string text = complaint("[capture]\nformt = \"grey\"\n[[capture.camera]]\n");
  EXPECT_THAT(text, HasSubstr("unknown key \"capture.formt\"; did you mean \"format\"?"));
  EXPECT_THAT(text, HasSubstr("capture.camera 1.name is missing"));
  EXPECT_THAT(text, HasSubstr("capture.camera 1.device is missing"));
  EXPECT_THAT(complaint("[capture]\ncamera = 3\n"),
              HasSubstr("capture.camera must be a list of [[camera]] sections"));
}

}  // namespace
}  // namespace glint
