// SPDX-License-Identifier: MIT
// Whatever is wrong when cameras are calibrated is said in a message that names it and what to do, with exit
// code 2 for the command line and 1 for the rest.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "host/calibrate/samples.hpp"
#include "host/config/rig.hpp"
#include "host/sim/rig.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"
#include "tests/unit/calibrate/waved_target.hpp"

namespace glint::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
namespace fs = std::filesystem;

class CalibrateBadInput : public ::testing::Test {
 protected:
  CalibrateBadInput() { write_calibration(rig(), truth_, false); }

  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }
  std::string rig() const { return path("lenses.toml"); }
  std::string output() const { return path("out.toml"); }

  SampleSet waved(std::size_t ticks) const {
    return wave(truth_, wand_target({0.0, 0.13, 0.39}, 0.0063), ticks, 0.05);
  }
  std::string write(const SampleSet& samples) const {
    write_samples(path("waved.jsonl"), samples, true);
    return path("waved.jsonl");
  }
  Outcome calibrate(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), "calibrate");
    return run_glint(arguments);
  }
  /// `glint calibrate extrinsics` of samples, with the right lenses.
  Outcome extrinsics(const SampleSet& samples, const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments{"extrinsics", "--from",  write(samples), "--rig",
                                       rig(),        "--quiet", "-o",           output()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return calibrate(arguments);
  }
  /// That message, that exit code, and no calibration.
  void expect_refused(const Outcome& o, int exit_code,
                      const ::testing::Matcher<const std::string&>& says) const {
    EXPECT_EQ(o.exit_code, exit_code) << o.err;
    EXPECT_THAT(o.err, says);
    EXPECT_FALSE(fs::exists(output()));
  }

  TempDir scratch_;
  Calibration truth_ = sim_calibration({});
};

TEST_F(CalibrateBadInput, NoWand) {
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"extrinsics", "sim", "--ticks", "1",
                                       "--device",   "cpu", "-o",      output()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return calibrate(arguments);
  };
  expect_refused(with({"--wand", "0,0"}), 2, AllOf(HasSubstr("wand 0,0"), HasSubstr("0.01 m")));
  expect_refused(with({"--wand", "0"}), 2, AllOf(HasSubstr("wand 0"), HasSubstr("two or three")));
  expect_refused(with({"--wand", "0,0.2,0.4"}), 2, HasSubstr("one and a half times"));
  expect_refused(with({}), 2, AllOf(HasSubstr("--wand"), HasSubstr("--marker")));
  expect_refused(with({"--wand", "0,0.5", "--marker"}), 2, AllOf(HasSubstr("--wand"), HasSubstr("--marker")));
  expect_refused(with({"--wand", "0,x"}), 2, HasSubstr("--wand"));
}

TEST_F(CalibrateBadInput, CheckWithoutAWandOrARig) {
  EXPECT_EQ(calibrate({"check", "sim"}).exit_code, 2);
  const Outcome o = calibrate({"check", "images:" + scratch_.string(), "--wand", "0,0.5"});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, HasSubstr("--rig"));
  const Outcome length = calibrate({"check", "sim", "--wand", "0,0", "--device", "cpu", "--ticks", "1"});
  EXPECT_EQ(length.exit_code, 2);
  EXPECT_THAT(length.err, HasSubstr("wand 0,0"));
}

TEST_F(CalibrateBadInput, SourceAndFrom) {
  expect_refused(calibrate({"extrinsics", "--wand", "0,0.5", "-o", output()}), 2, HasSubstr("--from"));
  expect_refused(calibrate({"extrinsics", "sim", "--from", "x.jsonl", "--wand", "0,0.5", "-o", output()}), 2,
                 HasSubstr("--from"));
  expect_refused(calibrate({"intrinsics", "-o", output()}), 2, HasSubstr("--from"));
  expect_refused(calibrate({"intrinsics", "sim", "-o", output()}), 2, HasSubstr("--board"));
  expect_refused(calibrate({"extrinsics", "--from", write(waved(50)), "-o", output()}), 2,
                 HasSubstr("--rig"));
}

TEST_F(CalibrateBadInput, UnknownFiles) {
  expect_refused(calibrate({"extrinsics", "--from", path("none.jsonl"), "--rig", rig(), "-o", output()}), 1,
                 HasSubstr("none.jsonl: cannot be read"));
  expect_refused(
      calibrate({"extrinsics", "--from", write(waved(50)), "--rig", path("none.toml"), "-o", output()}), 1,
      HasSubstr("none.toml"));
  expect_refused(calibrate({"intrinsics", "--from", path("none.jsonl"), "-o", output()}), 1,
                 HasSubstr("none.jsonl: cannot be read"));
  expect_refused(calibrate({"ground", "--rig", path("none.toml"), "--shift", "0,0,1", "-o", output()}), 1,
                 HasSubstr("none.toml"));
  const std::string broken = scratch_.write("broken.jsonl", "{\"kind\":\n").string();
  expect_refused(calibrate({"extrinsics", "--from", broken, "--rig", rig(), "-o", output()}), 1,
                 HasSubstr("broken.jsonl:1: "));
}

TEST_F(CalibrateBadInput, AnExistingOutputIsKept) {
  const std::string kept = scratch_.write("kept.toml", "precious\n").string();
  const std::string samples = write(waved(50));
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"extrinsics", "--from", samples, "--rig", rig(), "-o", kept},
        {"intrinsics", "--from", samples, "-o", kept},
        {"ground", "--rig", rig(), "--shift", "0,0,1", "-o", kept}}) {
    const Outcome o = calibrate(arguments);
    EXPECT_EQ(o.exit_code, 1);
    EXPECT_THAT(o.err, AllOf(HasSubstr("kept.toml"), HasSubstr("--force")));
    std::ifstream file(kept);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "precious\n");
  }
}

TEST_F(CalibrateBadInput, TooFewSamples) {
  const SampleSet few = waved(12);
  const std::string count = "only " + std::to_string(ticks_of(few).size()) + " samples";
  expect_refused(extrinsics(few), 1, AllOf(HasSubstr(count), HasSubstr("are needed")));
}

TEST_F(CalibrateBadInput, OtherSizesThanTheLensesAreFor) {
  SampleSet samples = waved(100);
  samples.cameras[1].width_px = 640;
  expect_refused(
      extrinsics(samples), 1,
      AllOf(HasSubstr("cam2"), HasSubstr("640x800"), HasSubstr("1280x800"), HasSubstr("intrinsics")));
}

TEST_F(CalibrateBadInput, ACameraThatTheRigHasNot) {
  SampleSet samples = waved(100);
  samples.cameras[2].name = "north";
  expect_refused(extrinsics(samples), 1, AllOf(HasSubstr("lenses.toml"), HasSubstr("north")));
}

TEST_F(CalibrateBadInput, OnlyAndDistanceNameCameras) {
  expect_refused(extrinsics(waved(100), {"--only", "north"}), 2,
                 AllOf(HasSubstr("--only"), HasSubstr("north"), HasSubstr("cam1, cam2")));
  for (const char* bad :
       {"cam1:cam2", "4.95", "cam1:cam2:x", "cam1:cam2:-1", "cam1:cam2:1m", "cam1:cam2:inf"})
    expect_refused(extrinsics(waved(100), {"--distance", bad}), 2,
                   AllOf(HasSubstr(std::string("--distance ") + bad), HasSubstr("cam1:cam2:4.95")));
  expect_refused(extrinsics(waved(100), {"--distance", "cam1:north:5"}), 2, HasSubstr("north"));
  expect_refused(extrinsics(waved(100), {"--distance", "cam1:cam2:5"}), 1, HasSubstr("scale"));
}

/// A marker moved over a table top: what the cameras see is the same from infinitely many places.
TEST_F(CalibrateBadInput, AllSamplesInOnePlane) {
  SampleSet flat;
  flat.target = marker_target(0.0);
  flat.cameras = sample_cameras(truth_);
  const std::vector<Camera> cameras(truth_.cameras.begin(), truth_.cameras.end());
  for (std::uint64_t tick = 0; tick < 400; ++tick) {
    const Eigen::Vector3d point(-0.9 + 0.09 * static_cast<double>(tick % 20),
                                -0.9 + 0.09 * static_cast<double>(tick / 20), 1.0);
    for (std::uint32_t c = 0; c < cameras.size(); ++c)
      if (const auto pixel = cameras[c].project(point); pixel && cameras[c].inside(*pixel))
        flat.sightings.push_back({tick, c, 0, *pixel});
  }
  expect_refused(extrinsics(flat, {"--distance", "cam1:cam2:5"}), 1,
                 AllOf(HasSubstr("one plane"), HasSubstr("high and low")));
  expect_refused(extrinsics(flat), 1, HasSubstr("distance"));
}

TEST_F(CalibrateBadInput, ATargetThatOneCameraAloneSees) {
  SampleSet alone = waved(300);
  std::erase_if(alone.sightings, [](const Sighting& s) { return s.camera != 0; });
  expect_refused(extrinsics(alone), 1, HasSubstr("cam"));
  SampleSet without = waved(300);
  std::erase_if(without.sightings, [](const Sighting& s) { return s.camera == 2; });
  expect_refused(extrinsics(without), 1, HasSubstr("cam3"));
}

TEST_F(CalibrateBadInput, IntrinsicsWantABoard) {
  const std::string samples = write(waved(100));
  expect_refused(calibrate({"intrinsics", "--from", samples, "-o", output()}), 1,
                 AllOf(HasSubstr("wand:0,0.13,0.39"), HasSubstr("board")));
  expect_refused(calibrate({"intrinsics", "--from", samples, "--only", "north", "-o", output()}), 2,
                 AllOf(HasSubstr("--only"), HasSubstr("north")));
  expect_refused(calibrate({"intrinsics", "sim", "--board", "checkers:9x6:25mm", "-o", output()}), 2,
                 HasSubstr("checkers"));
  expect_refused(calibrate({"intrinsics", "--from", samples, "--model", "fisheye", "-o", output()}), 2,
                 HasSubstr("fisheye"));
}

TEST_F(CalibrateBadInput, Ground) {
  const auto ground = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"ground", "--rig", rig(), "-o", output()});
    return calibrate(more);
  };
  expect_refused(ground({}), 2, HasSubstr("nothing to do"));
  expect_refused(calibrate({"ground", "--shift", "0,0,1", "-o", output()}), 2, HasSubstr("--rig"));
  expect_refused(ground({"--origin", "0,0,0"}), 2, AllOf(HasSubstr("--on-x"), HasSubstr("--in-plane")));
  expect_refused(ground({"--l-frame", "0.2:0.3"}), 2, HasSubstr("SOURCE"));
  for (const char* bad : {"1", "1:0", "0:1", "1:-1", "-1:1", "1:x", "nan:1", "1:inf", "inf:1"})
    expect_refused(ground({std::string("--scale=") + bad}), 2,
                   AllOf(HasSubstr(std::string("--scale ") + bad), HasSubstr("MEASURED:TRUE")));
  expect_refused(ground({"--origin", "0,0,0", "--on-x", "0,0,0", "--in-plane", "0,1,0"}), 1,
                 HasSubstr("marker"));
}

/// Before anybody waves in vain, or sees an option without effect.
TEST_F(CalibrateBadInput, WhatIsToldTwiceOrNowhereToBeWritten) {
  const auto sim = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"extrinsics", "sim", "--ticks", "1", "--device", "cpu", "-o", output()});
    return calibrate(more);
  };
  expect_refused(sim({"--wand", "0,0.5", "--board", "chessboard:9x6:25mm"}), 2, HasSubstr("one of them"));
  expect_refused(sim({"--marker"}), 2, HasSubstr("--distance"));
  expect_refused(sim({"--wand", "0,0.5", "--distance", "cam1:cam2:5"}), 2, HasSubstr("--marker alone"));
  expect_refused(sim({"--wand", "0,0.5", "--radius", "13"}), 2, HasSubstr("--radius"));
  expect_refused(sim({"--wand", "0,0.5", "--report", path("page.pdf")}), 2, HasSubstr(".html"));
  expect_refused(sim({"--wand", "0,0.5", "--samples", output()}), 2, HasSubstr("one file"));
  expect_refused(sim({"--wand", "0,0.5", "--json", path("none/x.json")}), 1, HasSubstr("there is no folder"));
  expect_refused(extrinsics(waved(50), {"--wand", "0,0.5"}), 2,
                 HasSubstr("--from FILE has its target in it"));
  expect_refused(extrinsics(waved(50), {"--distance", "cam1:cam2:5", "--only", "cam2"}), 2,
                 HasSubstr("--only"));
  expect_refused(
      calibrate({"extrinsics", "--points", "p.csv", "--rig", rig(), "--only", "cam1", "-o", output()}), 2,
      HasSubstr("--points"));
}

}  // namespace
}  // namespace glint::test
