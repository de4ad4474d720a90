// SPDX-License-Identifier: MIT
// Body files and the [[body]] sections of rig files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/config/bodies_file.hpp"
#include "host/config/rig.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::TempFolder;
using ::testing::HasSubstr;
using ::testing::StartsWith;

class BodiesFile : public ::testing::Test {
 protected:
  std::string complaint(const std::string& text) {
    return folder_.strip(error_of([&] { read_bodies(folder_.write("bodies.toml", text)); }));
  }
  static std::vector<BodyModel> two() {
    return {{"the \"drone\"", {{0.1, 0, 0}, {0, 1.0 / 3.0, 0}, {0, 0, -0.07}}, 0.00025},
            {"cart", {{0.2, 0, 0}, {-0.2, 0, 0}, {0, 0.1, 0}, {0, 0, 0.1}}}};
  }
  static constexpr const char* kHead = "format = 1\nkind = \"bodies\"\n";
  TempFolder folder_;
};

TEST_F(BodiesFile, WhatIsWrittenReadsBackTheSame) {
  const auto path = folder_ / "b.toml";
  const auto bodies = two();
  write_bodies(path, bodies);
  const auto again = read_bodies(path);
  ASSERT_EQ(again.size(), 2u);
  for (std::size_t b = 0; b < 2; ++b) {
    EXPECT_EQ(again[b].name, bodies[b].name);
    EXPECT_EQ(again[b].markers_in_body, bodies[b].markers_in_body);
    EXPECT_EQ(again[b].marker_sd_m, bodies[b].marker_sd_m);
  }
  EXPECT_THAT(error_of([&] { write_bodies(path, bodies); }), HasSubstr("exists"));
  write_bodies(path, bodies, true);
}

TEST_F(BodiesFile, DoesNotReplaceARigFile) {
  const auto path = folder_.write("rig.toml", "format = 1\nkind = \"rig\"\n");
  EXPECT_THAT(error_of([&] { write_bodies(path, two(), true); }), HasSubstr("is a rig file"));
}

TEST_F(BodiesFile, IsNotWrittenIfItCouldNotBeRead) {
  auto bodies = two();
  bodies[1].name = bodies[0].name;
  EXPECT_THAT(error_of([&] { write_bodies(folder_ / "b.toml", bodies); }), HasSubstr("is taken by body 1"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "b.toml"));
}

TEST_F(BodiesFile, SaysWhatIsWrongAndWhere) {
  const std::string head = kHead;
  EXPECT_EQ(complaint(head), "bodies.toml:1:1: no body; add a [[body]] section for each");
  EXPECT_EQ(complaint(head + "[[body]]\n"),
            "bodies.toml:3:1: body 1.name is missing\nbodies.toml:3:1: body 1.markers_in_body_m is missing");
  const std::string body = head + "[[body]]\nname = \"a\"\n";
  EXPECT_EQ(complaint(body + "markers_in_body_m = [[0, 0, 0], [1, 0]]\n"),
            "bodies.toml:5:33: body 1.markers_in_body_m must hold points of three numbers; one has 2");
  EXPECT_EQ(complaint(body + "markers_in_body_m = [[0, 0, 0], [\"x\", 0, 0]]\n"),
            "bodies.toml:5:33: body 1.markers_in_body_m must hold numbers only, not a string");
  EXPECT_EQ(
      complaint(body + "markers_in_body_m = 3\n"),
      "bodies.toml:5:21: body 1.markers_in_body_m must be an array of points, [[x, y, z], ...], not a whole "
      "number");
  const std::string sound = body + "markers_in_body_m = [[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0]]\n";
  EXPECT_EQ(complaint(sound), "no error");
  EXPECT_THAT(complaint(sound + "marker_sd_m = 0.3\n"),
              StartsWith("bodies.toml:6:15: body 1.marker_sd_m must be > 0 and at most"));
  EXPECT_EQ(complaint(sound + "marker_sd = 0.3\n"),
            "bodies.toml:6:1: unknown key \"body 1.marker_sd\"; did you mean \"marker_sd_m\"?");
  EXPECT_EQ(complaint(sound +
                      "[[body]]\nname = \"a\"\nmarkers_in_body_m = [[0, 0, 0], [0.1, 0, 0], [0, 0.2, 0]]\n"),
            "bodies.toml:7:8: body 2.name \"a\" is taken by body 1");
  EXPECT_THAT(complaint(body + "markers_in_body_m = [[0, 0, 0], [0.1, 0, 0], [0.3, 0, 0]]\n"),
              StartsWith("bodies.toml:5:21: body 1.markers_in_body_m lies on a line"));
  EXPECT_EQ(complaint("format = 1\nkind = \"calibration\"\n"),
            "bodies.toml:2:8: kind is \"calibration\"; here a body or rig file is wanted");
}

TEST_F(BodiesFile, ARigFileHoldsBodiesToo) {
  Calibration calibration;
  for (const char* name : {"north", "south"}) {
    CameraCalibration& camera = calibration.cameras.emplace_back();
    camera.name = name;
    camera.width_px = camera.height_px = 100;
  }
  write_calibration(folder_ / "cal.toml", calibration);
  std::string text =
      "format = 1\nkind = \"rig\"\n[rig]\nname = \"lab\"\nrate_hz = 90\ncalibration = \"cal.toml\"\n";
  for (const BodyModel& body : two()) text += body_section(body);
  const auto path = folder_.write("rig.toml", text);
  const Rig rig = read_rig(path);
  ASSERT_EQ(rig.bodies.size(), 2u);
  EXPECT_EQ(rig.bodies[1].name, "cart");
  EXPECT_EQ(rig.bodies[1].markers_in_body, two()[1].markers_in_body);
  const TempFolder elsewhere;
  EXPECT_EQ(to_toml(read_rig(elsewhere.write("shown.toml", to_toml(rig)))), to_toml(rig));
  EXPECT_EQ(read_bodies(path).size(), 2u);
  EXPECT_THAT(folder_.strip(error_of([&] { read_rig(folder_.write("r.toml", text + "colour = 1\n")); })),
              HasSubstr("unknown key \"body 2.colour\""));
  write_bodies(folder_ / "b.toml", rig.bodies);
  EXPECT_EQ(folder_.strip(error_of([&] { read_rig(folder_ / "b.toml"); })),
            "b.toml:4:8: kind is \"bodies\"; here a rig or calibration file is wanted");
}

}  // namespace
}  // namespace glint
