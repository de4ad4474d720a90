// SPDX-License-Identifier: MIT
// glint import and glint config as they are typed: what is written, what is refused, and which kind of error
// it is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/apps/commands.hpp"
#include "host/config/rig.hpp"
#include "tests/unit/config/config_fixture.hpp"

namespace glint {
namespace {

using test::TempFolder;
using ::testing::HasSubstr;

constexpr const char* kCameras =
    "[cam_0]\nsize = [640, 480]\nmatrix = [[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]]\n"
    "distortions = [0.0, 0, 0, 0, 0]\nrotation = [0.0, 0, 0]\ntranslation = [0.0, 0, 500]\n"
    "[cam_1]\nsize = [640, 480]\nmatrix = [[500.0, 0, 320], [0, 500.0, 240], [0, 0, 1]]\n"
    "distortions = [0.0, 0, 0, 0, 0]\nrotation = [0.0, 0, 0]\ntranslation = [250.0, 0, 500]\n";

struct Outcome {
  std::string out, error;
  int exit_code = 0;
};

/// Runs one command line (arguments separated by blanks) as main() would.
Outcome run(const std::string& line) {
  CLI::App app("glint");
  apps::add_import(app);
  apps::add_config(app);
  Outcome outcome;
  ::testing::internal::CaptureStdout();
  try {
    app.parse(line);
  } catch (const CLI::ParseError& error) {
    outcome.error = error.what();
    outcome.exit_code = 2;
  } catch (const UsageError& error) {
    outcome.error = error.what();
    outcome.exit_code = 2;
  } catch (const Error& error) {
    outcome.error = error.what();
    outcome.exit_code = 1;
  }
  outcome.out = ::testing::internal::GetCapturedStdout();
  return outcome;
}

class Commands : public ::testing::Test {
 protected:
  Commands() { folder_.write("in.toml", kCameras); }
  /// glint import calibration in.toml --output out.toml and `more`
  Outcome import(const std::string& more) {
    return run("import calibration " + (folder_ / "in.toml").string() + " --output " +
               (folder_ / "out.toml").string() + " " + more);
  }
  TempFolder folder_;
};

TEST_F(Commands, ImportWritesAFileThatCheckAccepts) {
  const Outcome imported = import("--unit mm --names left,right");
  EXPECT_EQ(imported.exit_code, 0) << imported.error;
  EXPECT_THAT(imported.out, HasSubstr("right  640x480  0.25 m from left"));
  const Calibration read = read_calibration(folder_ / "out.toml");
  ASSERT_EQ(read.cameras.size(), 2u);
  EXPECT_EQ(read.cameras[1].name, "right");
  EXPECT_EQ(read.cameras[0].world_from_camera.translation.z(), -0.5);
  EXPECT_EQ(read.made_from, "aniposelib: in.toml");
  EXPECT_EQ(read.made_at.size(), std::string("2024-05-06T07:08:09Z").size());
  const Outcome checked = run("config --check " + (folder_ / "out.toml").string());
  EXPECT_EQ(checked.exit_code, 0);
  EXPECT_THAT(checked.out, HasSubstr("out.toml: ok, 2 cameras"));
}

TEST_F(Commands, ImportOverwritesOnlyWhenForced) {
  folder_.write("out.toml", "mine");
  const Outcome refused = import("--unit mm");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.error, HasSubstr("exists already"));
  EXPECT_EQ(test::read_file(folder_ / "out.toml"), "mine");
  EXPECT_EQ(import("--unit mm --force").exit_code, 0);
}

TEST_F(Commands, UnitsAreAppliedExactly) {
  for (const auto& [unit, metres] :
       {std::pair("mm", 0.25), std::pair("cm", 2.5), std::pair("m", 250.0), std::pair("inch", 6.35)}) {
    ASSERT_EQ(import(std::string("--force --unit ") + unit).exit_code, 0);
    const Calibration read = read_calibration(folder_ / "out.toml");
    EXPECT_NEAR(-read.cameras[1].world_from_camera.translation.x(), metres, 1e-12) << unit;
  }
}

TEST_F(Commands, UsageErrors) {
  EXPECT_EQ(import("--unit yard").exit_code, 2);
  EXPECT_EQ(import("--format matlab").exit_code, 2);
  for (const char* size : {"1280", "x", "0x0", "1280x", "1280x800x3", "-1x5", "123456x1"}) {
    EXPECT_EQ(import(std::string("--unit mm --size ") + size).exit_code, 2) << size;
  }
  EXPECT_EQ(run("import calibration").exit_code, 2);
  EXPECT_EQ(run("config").exit_code, 2);
  EXPECT_EQ(run("config --show --check x").exit_code, 2);
  EXPECT_EQ(run("config --check x --rig y").exit_code, 2);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "out.toml"));
}

TEST_F(Commands, WhatIsWrongWithTheInputIsNotAUsageError) {
  EXPECT_EQ(import("").exit_code, 1);  // no unit
  EXPECT_EQ(import("--unit mm --names a,b,c").exit_code, 1);
  EXPECT_EQ(import("--unit mm --names a,").exit_code, 1);  // an empty name
  EXPECT_EQ(run("config --check " + (folder_ / "none.toml").string()).exit_code, 1);
}

TEST_F(Commands, ShowPrintsARigFileThatReadsBack) {
  ASSERT_EQ(import("--unit mm").exit_code, 0);
  const Outcome shown = run("config --show --rig " + (folder_ / "out.toml").string());
  EXPECT_EQ(shown.exit_code, 0);
  const Rig rig = read_rig(folder_.write("shown.toml", shown.out));
  EXPECT_EQ(rig.calibration.cameras.size(), 2u);
  EXPECT_EQ(rig.name, "out");
  EXPECT_THAT(run("config --show").out, HasSubstr("[detect]\nthreshold = 12\n"));
}

}  // namespace
}  // namespace glint
