// SPDX-License-Identifier: MIT
// Rig files: sections, defaults, the calibration they name, and what is said about bad ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/config/rig.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::TempFolder;
using ::testing::HasSubstr;
using ::testing::StartsWith;

/// Lines 1 to 7.
constexpr const char* kRig =
    "format = 1\nkind = \"rig\"\n\n[rig]\nname = \"lab\"\nrate_hz = 90\ncalibration = \"cal.toml\"\n";

Calibration two_cameras() {
  Calibration calibration;
  for (const char* name : {"north", "south"}) {
    CameraCalibration camera;
    camera.name = name;
    camera.width_px = 1280;
    camera.height_px = 800;
    camera.fx_px = camera.fy_px = 914.25;
    calibration.cameras.push_back(camera);
  }
  return calibration;
}

class RigFile : public ::testing::Test {
 protected:
  RigFile() { write_calibration(folder_ / "cal.toml", two_cameras()); }

  Rig read(const std::string& text) { return read_rig(folder_.write("rig.toml", text)); }
  std::string complaint(const std::string& text) {
    return folder_.strip(error_of([&] { read(text); }));
  }

  TempFolder folder_;
};

TEST_F(RigFile, ShortestFileGivesTheDefaults) {
  const Rig rig = read(kRig), defaults;
  EXPECT_EQ(rig.name, "lab");
  EXPECT_EQ(rig.rate_hz, 90.0);
  EXPECT_EQ(rig.calibration.cameras.size(), 2u);
  EXPECT_EQ(rig.path, folder_ / "rig.toml");
  EXPECT_EQ(rig.calibration_path, folder_ / "cal.toml");
  EXPECT_EQ(rig.gpu.device, "auto");
  EXPECT_EQ(rig.detect.threshold, 12u);
  EXPECT_EQ(rig.match.gate_px, defaults.match.gate_px);
  EXPECT_EQ(rig.track.max_missed_frames, defaults.track.max_missed_frames);
}

TEST_F(RigFile, EveryKeyReachesItsField) {
  const Rig rig = read(std::string(kRig) + R"(marker_radius_m = 0.0063
[gpu]
device = "cpu"
depth = 2
[detect]
threshold = 25
background_frames = 7
min_area_px = 3
max_area_px = 900
max_blobs_per_camera = 256
[match]
sigma_px = 0.25
gate_px = 1.5
min_cameras = 2
min_range_m = 0.5
max_range_m = 12.5
[track]
acceleration_sd_m_s2 = 10.5
max_speed_m_s = 11.5
confirm_frames_two_views = 5
max_missed_frames = 6
)");
  EXPECT_EQ(rig.marker_radius_m, 0.0063);
  EXPECT_EQ(rig.match.marker_radius_m, 0.0063);
  EXPECT_EQ(rig.gpu.device, "cpu");
  EXPECT_EQ(rig.gpu.depth, 2u);
  EXPECT_EQ(rig.detect.threshold, 25u);
  EXPECT_EQ(rig.detect.background_frames, 7u);
  EXPECT_EQ(rig.detect.min_area_px, 3u);
  EXPECT_EQ(rig.detect.max_area_px, 900u);
  EXPECT_EQ(rig.detect.max_blobs_per_camera, 256u);
  EXPECT_EQ(rig.match.sigma_px, 0.25);
  EXPECT_EQ(rig.match.gate_px, 1.5);
  EXPECT_EQ(rig.match.min_cameras, 2u);
  EXPECT_EQ(rig.match.min_range_m, 0.5);
  EXPECT_EQ(rig.match.max_range_m, 12.5);
  EXPECT_EQ(rig.track.acceleration_sd_m_s2, 10.5);
  EXPECT_EQ(rig.track.max_speed_m_s, 11.5);
  EXPECT_EQ(rig.track.confirm_frames_two_views, 5u);
  EXPECT_EQ(rig.track.max_missed_frames, 6u);
}

TEST_F(RigFile, ACalibrationFileAloneIsARigWithDefaults) {
  const Rig rig = read_rig(folder_ / "cal.toml");
  EXPECT_EQ(rig.name, "cal");
  EXPECT_EQ(rig.calibration.cameras.size(), 2u);
  EXPECT_EQ(rig.calibration_path, folder_ / "cal.toml");
  EXPECT_EQ(rig.rate_hz, 90.0);
}

TEST_F(RigFile, TheDefaultsPassTheirOwnChecks) {
  std::vector<std::string> problems;
  const Rig rig;
  rig.gpu.check(problems);
  rig.detect.check(problems);
  rig.match.check(problems);
  rig.track.check(problems);
  EXPECT_THAT(problems, ::testing::IsEmpty());
}

TEST_F(RigFile, WhatShowPrintsReadsBackTheSame) {
  Rig rig = read(kRig);
  rig.name = "the \"lab\"";
  rig.rate_hz = 1.0 / 3.0;
  rig.marker_radius_m = 0.0063;
  rig.match.sigma_px = 0.1;
  rig.detect.threshold = 17;
  rig.track.max_missed_frames = 3;
  const TempFolder elsewhere;
  const Rig again = read_rig(elsewhere.write("shown.toml", to_toml(rig)));
  EXPECT_EQ(to_toml(again), to_toml(rig));
  EXPECT_EQ(again.name, rig.name);
  EXPECT_EQ(again.rate_hz, rig.rate_hz);
  EXPECT_EQ(again.match.marker_radius_m, 0.0063);
  EXPECT_EQ(again.detect.threshold, 17u);
  test::expect_same(again.calibration, rig.calibration);
}

TEST_F(RigFile, ShowWithoutARigPrintsTheDefaults) {
  EXPECT_THAT(to_toml(Rig{}), HasSubstr("threshold = 12\n"));
  EXPECT_THAT(to_toml(Rig{}), HasSubstr("# calibration = "));
}

TEST_F(RigFile, MissingFile) {
  EXPECT_EQ(folder_.strip(error_of([&] { read_rig(folder_ / "none.toml"); })),
            "none.toml: cannot be read: No such file or directory");
}

TEST_F(RigFile, MissingParts) {
  EXPECT_EQ(complaint("format = 1\nkind = \"rig\"\n"), "rig.toml:1:1: rig is missing");
  EXPECT_EQ(complaint("format = 1\nkind = \"rig\"\n[rig]\n"),
            "rig.toml:3:1: rig.name is missing\n"
            "rig.toml:3:1: rig.rate_hz is missing\n"
            "rig.toml:3:1: rig.calibration is missing");
  EXPECT_EQ(complaint(""), "rig.toml:1:1: format is missing\nrig.toml:1:1: kind is missing");
}

TEST_F(RigFile, UnknownKeysAndSections) {
  EXPECT_EQ(complaint(std::string(kRig) + "[detect]\ntreshold = 30\n"),
            "rig.toml:9:1: unknown key \"detect.treshold\"; did you mean \"threshold\"?");
  EXPECT_EQ(complaint(std::string(kRig) + "[detekt]\nthreshold = 30\n"),
            "rig.toml:8:2: unknown key \"detekt\"; did you mean \"detect\"?");
  EXPECT_EQ(complaint(std::string(kRig) + "colour = \"red\"\n"), "rig.toml:8:1: unknown key \"rig.colour\"");
}

TEST_F(RigFile, WrongTypes) {
  EXPECT_EQ(complaint(std::string(kRig) + "[detect]\nthreshold = 30.5\n"),
            "rig.toml:9:13: detect.threshold must be a whole number, not a number with a fraction");
  EXPECT_EQ(complaint(std::string(kRig) + "[gpu]\ndevice = 0\n"),
            "rig.toml:9:10: gpu.device must be a string, not a whole number");
  EXPECT_EQ(complaint("detect = 3\n" + std::string(kRig)),
            "rig.toml:1:10: detect must be a table, not a whole number");
}

TEST_F(RigFile, OutOfRange) {
  EXPECT_EQ(complaint(std::string(kRig) + "marker_radius_m = 6.3\n"),
            "rig.toml:8:19: rig.marker_radius_m must be 0 (unknown) to 1, not 6.3; it is in metres");
  EXPECT_EQ(complaint(std::string(kRig) + "[detect]\nthreshold = 255\nmax_blobs_per_camera = 0\n"),
            "rig.toml:9:13: detect.threshold must be 0 to 254 grey levels, not 255\n"
            "rig.toml:10:24: detect.max_blobs_per_camera must be 1 to 65536, not 0");
  EXPECT_EQ(complaint(std::string(kRig) + "[detect]\nthreshold = -1\n"),
            "rig.toml:9:13: detect.threshold must not be negative; it is -1");
  EXPECT_EQ(complaint(std::string(kRig) + "[detect]\nmin_area_px = 9\nmax_area_px = 8\n"),
            "rig.toml:10:15: detect.max_area_px must be at least min_area_px (9), not 8");
  EXPECT_EQ(complaint(std::string(kRig) + "[gpu]\ndepth = 9\n"),
            "rig.toml:9:9: gpu.depth must be 1 to 4, not 9");
  EXPECT_EQ(
      complaint("format = 1\nkind = \"rig\"\n[rig]\nname = \"a\"\nrate_hz = 0\ncalibration = \"cal.toml\"\n"),
      "rig.toml:5:11: rig.rate_hz must be > 0 and <= 10000, not 0");
}

TEST_F(RigFile, WhatTheMatcherAndTheTrackerRefuseIsPlacedAtItsKey) {
  EXPECT_THAT(complaint(std::string(kRig) + "[match]\nsigma_px = 0.1\ngate_px = -1\n"),
              StartsWith("rig.toml:10:11: match.gate_px "));
  EXPECT_THAT(complaint(std::string(kRig) + "[match]\n\nmin_cameras = 1\n"),
              StartsWith("rig.toml:10:15: match.min_cameras "));
  EXPECT_THAT(complaint(std::string(kRig) + "[track]\nmax_speed_m_s = 0\n"),
              StartsWith("rig.toml:9:17: track.max_speed_m_s "));
}

TEST_F(RigFile, TheMarkersPlaneIsForOneCamera) {
  const std::string plane = "[match]\nplane_height_m = 0.25\n";
  EXPECT_THAT(complaint(kRig + plane),
              StartsWith("rig.toml:9:18: match.plane_height_m is for a rig of one camera"));
  Calibration one = two_cameras();
  one.cameras.pop_back();
  write_calibration(folder_ / "cal.toml", one, true);
  EXPECT_THAT(complaint(std::string(kRig) + "[match]\nplane_height_m = 200\n"),
              StartsWith("rig.toml:9:18: match.plane_height_m must be -100 to 100"));
  const Rig rig = read(kRig + plane);
  EXPECT_EQ(rig.match.plane_height_m, 0.25);
  const TempFolder elsewhere;
  EXPECT_EQ(read_rig(elsewhere.write("shown.toml", to_toml(rig))).match.plane_height_m, 0.25);
}

TEST_F(RigFile, NotFinite) {
  EXPECT_EQ(complaint(std::string(kRig) + "[match]\ngate_px = nan\n"),
            "rig.toml:9:11: match.gate_px must be a finite number, not nan");
}

TEST_F(RigFile, MoreCamerasWantedThanThereAre) {
  EXPECT_EQ(complaint(std::string(kRig) + "[match]\nmin_cameras = 3\n"),
            "rig.toml:9:15: match.min_cameras is more than the 2 cameras of the calibration");
}

TEST_F(RigFile, ABadCalibrationIsNamedAtItsKey) {
  std::filesystem::remove(folder_ / "cal.toml");
  EXPECT_EQ(
      complaint(kRig),
      "rig.toml:7:15: rig.calibration cannot be used: cal.toml: cannot be read: No such file or directory");
  folder_.write("cal.toml", kRig);
  EXPECT_EQ(complaint(kRig), "cal.toml:2:8: kind is \"rig\"; here a calibration file is wanted");
}

TEST_F(RigFile, ProblemsOfBothFilesAreListedTogether) {
  folder_.write("cal.toml", "format = 1\nkind = \"calibration\"\nmade_at = 3\n");
  EXPECT_EQ(complaint(std::string(kRig) + "[gpu]\ndepth = 0\n[detect]\nthreshold = \"high\"\n"),
            "rig.toml:9:9: gpu.depth must be 1 to 4, not 0\n"
            "rig.toml:11:13: detect.threshold must be a whole number, not a string\n"
            "cal.toml:1:1: no camera; add a [[camera]] section for each\n"
            "cal.toml:3:11: made_at must be a string, not a whole number");
}

TEST_F(RigFile, TheExamplesInTheDocumentationAreValid) {
  const Rig rig = read_rig("docs/rig.example.toml");
  EXPECT_EQ(rig.calibration.cameras.size(), 4u);
  for (const CameraCalibration& camera : rig.calibration.cameras) {
    const auto pixel = Camera(camera).project({0.0, 0.0, 1.0});  // what its comment says they look at
    ASSERT_TRUE(pixel) << camera.name;
    EXPECT_LT((*pixel - Eigen::Vector2d(639.5, 399.5)).norm(), 1e-9) << camera.name;
  }
  const Rig defaults;
  EXPECT_EQ(rig.detect.min_area_px, defaults.detect.min_area_px);
  EXPECT_EQ(rig.match.sigma_px, defaults.match.sigma_px);
  EXPECT_EQ(rig.track.acceleration_sd_m_s2, defaults.track.acceleration_sd_m_s2);
}

}  // namespace
}  // namespace glint
