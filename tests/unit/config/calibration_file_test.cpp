// SPDX-License-Identifier: MIT
// Calibration files: nothing is lost on the way, and every kind of bad input is named with its place.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <limits>
#include <random>

#include "host/config/rig.hpp"
#include "host/files/text_file.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::TempFolder;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr const char* kHead = "format = 1\nkind = \"calibration\"\n";

/// Lines 3 to 12 of a file, when they follow kHead directly; kCameraLines lines.
std::string camera_text(const std::string& name) {
  return "[[camera]]\nname = \"" + name +
         "\"\nwidth_px = 1280\nheight_px = 800\nfx_px = 900\nfy_px = 901.5\ncx_px = 639.5\ncy_px = 399.5\n"
         "k1_k2_p1_p2_k3 = [0.1, 0, 0, 0, 0]\n"
         "world_from_camera = { x_m = 1, y_m = 2, z_m = 3, qx = 0, qy = 0, qz = 0, qw = 1 }\n";
}

/// What reading a file of kHead and one camera says when `from` stands as `to` in it.
std::string complaint(const std::string& from, const std::string& to) {
  const TempFolder folder;
  std::string text = kHead + camera_text("a");
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos);
  text.replace(at, from.size(), to);
  return folder.strip(error_of([&] { read_calibration(folder.write("c.toml", text)); }));
}

Calibration random_calibration(unsigned seed, std::size_t cameras) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  Calibration calibration;
  calibration.made_at = "2024-05-06T07:08:09Z";
  calibration.made_from = "wand \"x\" \\ tab\t \u00e4";
  for (std::size_t n = 0; n < cameras; ++n) {
    CameraCalibration camera;
    camera.name = "cam " + std::to_string(n);
    camera.width_px = 1280;
    camera.height_px = 800;
    camera.fx_px = 900.0 + normal(random);
    camera.fy_px = -900.0 + normal(random);
    camera.cx_px = normal(random) * 640.0;
    camera.cy_px = normal(random) * 1e-7;
    for (double& k : camera.k1_k2_p1_p2_k3) k = normal(random);
    const Eigen::Vector4d q(normal(random), normal(random), normal(random), normal(random));
    camera.world_from_camera.rotation.coeffs() = q.normalized();
    camera.world_from_camera.translation = {normal(random), normal(random) * 1e5, normal(random) * 1e-5};
    camera.rms_px = std::abs(normal(random));
    if (n % 2 == 0)
      for (double& sd : camera.intrinsics_sd) sd = std::abs(normal(random));
    calibration.cameras.push_back(camera);
  }
  return calibration;
}

TEST(CalibrationFile, WritingAndReadingLosesNothing) {
  const TempFolder folder;
  for (unsigned seed = 1; seed <= 32; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    const Calibration written = random_calibration(seed, seed);
    write_calibration(folder / "c.toml", written, true);
    test::expect_same(read_calibration(folder / "c.toml"), written);
  }
}

TEST(CalibrationFile, ExtremeNumbersSurvive) {
  const TempFolder folder;
  Calibration written = random_calibration(1, 1);
  CameraCalibration& camera = written.cameras[0];
  camera.fx_px = std::numeric_limits<double>::max();
  camera.fy_px = 1e22;
  camera.cx_px = -0.0;
  camera.cy_px = std::numeric_limits<double>::min();
  camera.k1_k2_p1_p2_k3 = {0.1, 1.0 / 3.0, std::numeric_limits<double>::denorm_min(), -1e-300, 123456789.0};
  write_calibration(folder / "c.toml", written);
  test::expect_same(read_calibration(folder / "c.toml"), written);
}

TEST(CalibrationFile, ReadsWhatAPersonWrites) {
  const TempFolder folder;
  const auto path = folder.write("c.toml", kHead + camera_text("a") + camera_text("b"));
  const Calibration read = read_calibration(path);
  ASSERT_EQ(read.cameras.size(), 2u);
  EXPECT_EQ(read.cameras[1].name, "b");
  EXPECT_EQ(read.cameras[0].fx_px, 900.0);
  EXPECT_EQ(read.cameras[0].world_from_camera.translation, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(read.cameras[0].rms_px, 0.0);
}

TEST(CalibrationFile, AQuaternionOfFourDigitsIsMadeExact) {
  const TempFolder folder;
  std::string text = kHead + camera_text("a");
  const std::string from = "qz = 0, qw = 1";
  text.replace(text.find(from), from.size(), "qz = 0.7071, qw = 0.7071");
  const Calibration read = read_calibration(folder.write("c.toml", text));
  EXPECT_NEAR(read.cameras[0].world_from_camera.rotation.norm(), 1.0, 1e-15);
  EXPECT_NEAR(read.cameras[0].world_from_camera.rotation.w(), std::sqrt(0.5), 1e-15);
}

TEST(CalibrationFile, ExistingFilesAreKeptUnlessForced) {
  const TempFolder folder;
  const auto path = folder.write("c.toml", "mine");
  EXPECT_THAT(error_of([&] { write_calibration(path, random_calibration(1, 1)); }),
              HasSubstr("exists already"));
  EXPECT_EQ(test::read_file(path), "mine");
  write_calibration(path, random_calibration(1, 1), true);
  EXPECT_EQ(read_calibration(path).cameras.size(), 1u);
}

TEST(CalibrationFile, AFailedWriteLeavesNothingBehind) {
  const TempFolder folder;
  EXPECT_THAT(error_of([&] { write_calibration(folder / "none/c.toml", random_calibration(1, 1)); }),
              HasSubstr("cannot be written: No such file or directory"));
  std::filesystem::create_directory(folder / "folder");
  EXPECT_THAT(error_of([&] { write_calibration(folder / "folder", random_calibration(1, 1), true); }),
              HasSubstr("cannot be written: Is a directory"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / ""), {}), 1);
}

TEST(CalibrationFile, ADiskThatFillsUpLeavesTheOldFile) {
  const TempFolder folder;
  const auto path = folder.write("c.toml", "mine");
  ::rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  ::rlimit little = before;
  little.rlim_cur = 100;
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &little), 0);
  const std::string message = error_of([&] { write_calibration(path, random_calibration(1, 1), true); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(folder.strip(message), "c.toml: cannot be written: File too large");
  EXPECT_EQ(test::read_file(path), "mine");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder / ""), {}), 1);
}

TEST(CalibrationFile, WhatCannotBeReadBackIsNotWritten) {
  const TempFolder folder;
  Calibration calibration = random_calibration(1, 2);
  calibration.cameras[1].world_from_camera.rotation.coeffs() *= 2.0;
  EXPECT_THAT(error_of([&] { write_calibration(folder / "c.toml", calibration); }),
              HasSubstr("has a quaternion of length 2"));
  calibration = random_calibration(1, 1);
  calibration.cameras[0].fx_px = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(error_of([&] { write_calibration(folder / "c.toml", calibration); }),
              HasSubstr("must be a finite number, not nan"));
  EXPECT_FALSE(std::filesystem::exists(folder / "c.toml"));
}

TEST(CalibrationFile, MissingFileFolderAndHugeFile) {
  const TempFolder folder;
  EXPECT_EQ(folder.strip(error_of([&] { read_calibration(folder / "none.toml"); })),
            "none.toml: cannot be read: No such file or directory");
  EXPECT_THAT(error_of([&] { read_calibration(folder / ""); }), HasSubstr("cannot be read: Is a directory"));
  const auto huge = folder.write("huge.toml", std::string(kMaxConfigFileBytes + 1, '#'));
  EXPECT_EQ(folder.strip(error_of([&] { read_calibration(huge); })),
            "huge.toml: is larger than 1000000 bytes; is it the right file?");
}

TEST(CalibrationFile, BrokenToml) {
  EXPECT_THAT(complaint("fx_px = 900", "fx_px = 900 901"), StartsWith("c.toml:7:13: not TOML: "));
  EXPECT_THAT(complaint("name = \"a\"", "name = \"a\"\nname = \"b\""), StartsWith("c.toml:5:8: not TOML: "));
  EXPECT_THAT(complaint("name = \"a\"", "name = \"a"), StartsWith("c.toml:4:10: not TOML: "));
}

TEST(CalibrationFile, DeepNestingIsRefusedNotFatal) {
  EXPECT_THAT(complaint("fx_px = 900", "fx_px = " + std::string(100000, '[')), HasSubstr(": not TOML: "));
}

TEST(CalibrationFile, Header) {
  EXPECT_EQ(complaint("format = 1\n", ""), "c.toml:1:1: format is missing");
  EXPECT_EQ(complaint("format = 1", "format = 2"),
            "c.toml:1:10: format 2 is unknown; this program reads format 1 (the file is of a newer glint)");
  EXPECT_EQ(complaint("format = 1", "format = \"1\""),
            "c.toml:1:10: format must be a whole number, not a string");
  EXPECT_EQ(complaint("kind = \"calibration\"", "kind = \"calib\""),
            "c.toml:2:8: kind must be \"rig\", \"calibration\" or \"bodies\", not \"calib\"");
  EXPECT_EQ(complaint("kind = \"calibration\"", "kind = \"rig\""),
            "c.toml:2:8: kind is \"rig\"; here a calibration file is wanted");
  EXPECT_EQ(complaint("kind = \"calibration\"", ""), "c.toml:1:1: kind is missing");
}

TEST(CalibrationFile, UnknownKey) {
  EXPECT_EQ(complaint("cx_px = 639.5", "cx_px = 639.5\nskew = 1"),
            "c.toml:10:1: unknown key \"camera 1.skew\"");
  EXPECT_EQ(complaint("kind = \"calibration\"", "kind = \"calibration\"\nmade_form = \"x\""),
            "c.toml:3:1: unknown key \"made_form\"; did you mean \"made_from\"?");
  EXPECT_EQ(complaint("qw = 1 }", "qw = 1, qn = 2 }"),
            "c.toml:12:82: unknown key \"camera 1.world_from_camera.qn\"; did you mean \"qx\"?");
}

TEST(CalibrationFile, WrongType) {
  EXPECT_EQ(complaint("fx_px = 900", "fx_px = \"900\""),
            "c.toml:7:9: camera 1.fx_px must be a number, not a string");
  EXPECT_EQ(complaint("width_px = 1280", "width_px = 1280.0"),
            "c.toml:5:12: camera 1.width_px must be a whole number, not a number with a fraction");
  EXPECT_EQ(complaint("name = \"a\"", "name = 3"),
            "c.toml:4:8: camera 1.name must be a string, not a whole number");
  EXPECT_EQ(complaint("[[camera]]", "[camera]"),
            "c.toml:3:1: camera must be written [[camera]] with two pairs of brackets");
  EXPECT_EQ(
      complaint("[0.1, 0, 0, 0, 0]", "0.1"),
      "c.toml:11:18: camera 1.k1_k2_p1_p2_k3 must be an array of 5 numbers, not a number with a fraction");
  EXPECT_EQ(complaint("[0.1, 0, 0, 0, 0]", "[0.1, 0, 0, 0]"),
            "c.toml:11:18: camera 1.k1_k2_p1_p2_k3 must be an array of 5 numbers; it has 4");
  EXPECT_EQ(complaint("[0.1, 0, 0, 0, 0]", "[0.1, 0, true, 0, 0]"),
            "c.toml:11:27: camera 1.k1_k2_p1_p2_k3 must hold numbers only, not true or false");
}

TEST(CalibrationFile, MissingKey) {
  EXPECT_EQ(complaint("fx_px = 900\n", ""), "c.toml:3:1: camera 1.fx_px is missing");
  EXPECT_EQ(complaint(", qw = 1", ""), "c.toml:12:21: camera 1.world_from_camera.qw is missing");
}

TEST(CalibrationFile, OutOfRange) {
  EXPECT_EQ(complaint("width_px = 1280", "width_px = 0"),
            "c.toml:5:12: camera 1.width_px must be 1 to 65535, not 0");
  EXPECT_EQ(complaint("height_px = 800", "height_px = -800"),
            "c.toml:6:13: camera 1.height_px must be 1 to 65535, not -800");
  EXPECT_EQ(complaint("height_px = 800", "height_px = 65535"),
            "c.toml:5:12: camera 1.width_px times height_px must be at most 16777216 pixels");
  EXPECT_EQ(complaint("fy_px = 901.5", "fy_px = 0.0"), "c.toml:8:9: camera 1.fy_px must not be 0");
  EXPECT_EQ(complaint("cx_px = 639.5", "cx_px = 639.5\nrms_px = -1"),
            "c.toml:10:10: camera 1.rms_px must not be negative (0: unknown)");
  EXPECT_EQ(complaint("cx_px = 639.5", "cx_px = 639.5\nintrinsics_sd = [1, 1, 1, 1, 0, 0, 0, -1e-9, 0]"),
            "c.toml:10:17: camera 1.intrinsics_sd must not be negative (all 0: unknown)");
}

TEST(CalibrationFile, NotFinite) {
  EXPECT_EQ(complaint("cx_px = 639.5", "cx_px = nan"),
            "c.toml:9:9: camera 1.cx_px must be a finite number, not nan");
  EXPECT_EQ(complaint("y_m = 2", "y_m = -inf"),
            "c.toml:12:38: camera 1.world_from_camera.y_m must be a finite number, not -inf");
  EXPECT_EQ(complaint("[0.1, 0, 0", "[0.1, inf, 0"),
            "c.toml:11:24: camera 1.k1_k2_p1_p2_k3 must be a finite number, not inf");
}

TEST(CalibrationFile, SingularPose) {
  EXPECT_EQ(complaint("qw = 1", "qw = 0"),
            "c.toml:12:21: camera 1.world_from_camera has the quaternion 0 0 0 0, which is no rotation "
            "(none: qw = 1)");
  EXPECT_EQ(
      complaint("qw = 1", "qw = 1.002"),
      "c.toml:12:21: camera 1.world_from_camera has a quaternion of length 1.002; a rotation has length 1 "
      "(within 0.001)");
  EXPECT_EQ(
      complaint("qx = 0", "qx = 1"),
      "c.toml:12:21: camera 1.world_from_camera has a quaternion of length 1.41421; a rotation has length 1 "
      "(within 0.001)");
  EXPECT_EQ(
      complaint("qx = 0", "qx = 1e300"),
      "c.toml:12:21: camera 1.world_from_camera has a quaternion of length 1e+300; a rotation has length 1 "
      "(within 0.001)");
}

TEST(CalibrationFile, CameraNames) {
  EXPECT_EQ(complaint("name = \"a\"", "name = \"\""), "c.toml:4:8: camera 1.name must not be empty");
  EXPECT_EQ(complaint("name = \"a\"", "name = \"../a\""),
            "c.toml:4:8: camera 1.name must not contain / (it becomes a folder's name and a CSV field)");
  EXPECT_EQ(complaint("name = \"a\"", "name = \"a\\nb\""),
            "c.toml:4:8: camera 1.name must not contain control characters");
  const TempFolder folder;
  const auto path = folder.write("c.toml", kHead + camera_text("a") + camera_text("b") + camera_text("a"));
  EXPECT_EQ(folder.strip(error_of([&] { read_calibration(path); })),
            "c.toml:24:8: camera 3.name \"a\" is taken by camera 1");
}

TEST(CalibrationFile, NumberOfCameras) {
  const TempFolder folder;
  const auto none = folder.write("none.toml", kHead);
  EXPECT_EQ(folder.strip(error_of([&] { read_calibration(none); })),
            "none.toml:1:1: no camera; add a [[camera]] section for each");
  const auto empty = folder.write("empty.toml", std::string(kHead) + "camera = []\n");
  EXPECT_EQ(folder.strip(error_of([&] { read_calibration(empty); })),
            "empty.toml:3:10: no camera; add a [[camera]] section for each");
  std::string text = kHead;
  for (int n = 0; n < 32; ++n) text += camera_text("cam" + std::to_string(n));
  EXPECT_EQ(read_calibration(folder.write("32.toml", text)).cameras.size(), 32u);
  text += camera_text("one more");
  EXPECT_EQ(folder.strip(error_of([&] { read_calibration(folder.write("33.toml", text)); })),
            "33.toml:323:1: 33 cameras; at most 32 are supported");
}

TEST(CalibrationFile, AllProblemsAtOnceInTheOrderOfTheFile) {
  const TempFolder folder;
  const auto path = folder.write("c.toml", std::string(kHead) +
                                               "[[camera]]\n"
                                               "name = 7\n"
                                               "width_px = 0\n"
                                               "heigth_px = 800\n"
                                               "fx_px = inf\n"
                                               "fy_px = 900\n"
                                               "cx_px = 1\n"
                                               "cy_px = 1\n"
                                               "k1_k2_p1_p2_k3 = []\n"
                                               "world_from_camera = 3\n");
  EXPECT_EQ(folder.strip(error_of([&] { read_calibration(path); })),
            "c.toml:3:1: camera 1.height_px is missing\n"
            "c.toml:4:8: camera 1.name must be a string, not a whole number\n"
            "c.toml:5:12: camera 1.width_px must be 1 to 65535, not 0\n"
            "c.toml:6:1: unknown key \"camera 1.heigth_px\"; did you mean \"height_px\"?\n"
            "c.toml:7:9: camera 1.fx_px must be a finite number, not inf\n"
            "c.toml:11:18: camera 1.k1_k2_p1_p2_k3 must be an array of 5 numbers; it has 0\n"
            "c.toml:12:21: camera 1.world_from_camera must be a table, not a whole number");
}

TEST(CalibrationFile, EveryTruncationIsAnErrorNotACrash) {
  const TempFolder folder;
  const std::string text = kHead + camera_text("a");
  const std::size_t last_needed = text.find("qw = 1 }") + 8;
  for (std::size_t length = 0; length < last_needed; ++length) {
    const auto path = folder.write("c.toml", text.substr(0, length));
    EXPECT_NE(error_of([&] { read_calibration(path); }), "no error") << length;
  }
}

TEST(CalibrationFile, NeverReplacesARigFile) {
  const TempFolder folder;
  const std::string text = "format = 1\nkind = \"rig\"  # with settings of its own\n";
  const auto path = folder.write("rig.toml", text);
  Calibration calibration;
  calibration.cameras.resize(1);
  calibration.cameras[0].name = "a";
  calibration.cameras[0].width_px = 640, calibration.cameras[0].height_px = 480;
  const std::string error = error_of([&] { write_calibration(path, calibration, true); });
  EXPECT_NE(error.find("is a rig file"), std::string::npos) << error;
  EXPECT_EQ(read_text_file(path, 1000), text);
}

}  // namespace
}  // namespace glint
