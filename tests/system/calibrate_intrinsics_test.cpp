// SPDX-License-Identifier: MIT
// `glint calibrate board` and `glint calibrate intrinsics` as a person runs them: the simulated session, the
// same again from its samples, and whatever can be wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "host/config/rig.hpp"
#include "host/sim/rig.hpp"
#include "host/target/board_finder.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

using ::testing::HasSubstr;
namespace fs = std::filesystem;

constexpr const char* kBoard = "charuco:8x5:40mm:30mm:5X5_100";

class CalibrateIntrinsics : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!have_board_finder()) GTEST_SKIP() << "built without OpenCV";
  }
  std::string file(const std::string& name) const { return (scratch_.path() / name).string(); }
  Outcome calibrate(const std::string& source, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"calibrate", "intrinsics", source,           "--board",
                                       kBoard,      "--output",   file("lens.toml")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_glint(arguments);
  }
  static std::string text_of(const std::string& path) {
    std::ifstream in(path);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  TempDir scratch_;
};

TEST_F(CalibrateIntrinsics, FindsTheSimulatedLensesAndDoesSoAgainFromTheSamples) {
  const Outcome taken =
      calibrate("sim", {"--cameras", "2", "--sim-views", "30", "--k3", "--json", file("lens.json")});
  ASSERT_EQ(taken.exit_code, 0) << taken.err;
  EXPECT_THAT(taken.out, HasSubstr("minus the truth"));
  const Calibration found = read_calibration(file("lens.toml"));
  SimOptions options;
  options.cameras = 2;
  const Calibration truth = sim_calibration(options);
  ASSERT_EQ(found.cameras.size(), 2u);
  for (std::size_t c = 0; c < 2; ++c) {
    const CameraCalibration &a = found.cameras[c], &b = truth.cameras[c];
    EXPECT_EQ(a.name, b.name);
    EXPECT_NEAR(a.fx_px, b.fx_px, 4.0 * a.intrinsics_sd[0]);
    EXPECT_NEAR(a.cy_px, b.cy_px, 4.0 * a.intrinsics_sd[3]);
    EXPECT_LT(a.intrinsics_sd[0], 0.3);
    EXPECT_LT(a.rms_px, 0.08);
  }
  const auto json = nlohmann::json::parse(text_of(file("lens.json")));
  EXPECT_EQ(json["board"], kBoard);
  EXPECT_EQ(json["cameras"][1]["fx_px"].get<double>(), found.cameras[1].fx_px);
  EXPECT_EQ(json["cameras"][0]["verdict"], "excellent");

  const Outcome again = run_glint({"calibrate", "intrinsics", "--from", file("lens.samples.jsonl"),
                                   "--output", file("again.toml"), "--k3", "--only", "cam2"});
  ASSERT_EQ(again.exit_code, 0) << again.err;
  const Calibration repeated = read_calibration(file("again.toml"));
  ASSERT_EQ(repeated.cameras.size(), 1u);
  EXPECT_EQ(repeated.cameras[0].fx_px, found.cameras[1].fx_px);
  EXPECT_EQ(repeated.cameras[0].k1_k2_p1_p2_k3, found.cameras[1].k1_k2_p1_p2_k3);
  EXPECT_EQ(repeated.cameras[0].intrinsics_sd, found.cameras[1].intrinsics_sd);
}

TEST_F(CalibrateIntrinsics, KeepsTheSamplesOfASessionThatIsTooShort) {
  const Outcome few = calibrate("sim", {"--cameras", "1", "--sim-views", "3"});
  EXPECT_EQ(few.exit_code, 1);
  EXPECT_THAT(few.err, HasSubstr("cam1: only 3 different views of the board; show it in 5 at least"));
  EXPECT_THAT(few.err, HasSubstr("no calibration was written"));
  EXPECT_FALSE(fs::exists(file("lens.toml")));
  EXPECT_TRUE(fs::exists(file("lens.samples.jsonl")));
}

TEST_F(CalibrateIntrinsics, SaysWhenThereIsNoBoardAndWhenSizesDiffer) {
  for (const auto& [name, width] : {std::pair{"a", "320"}, std::pair{"b", "480"}}) {
    ASSERT_EQ(run_glint({"sim", "--out", file(name), "--seconds", "0.05", "--width", width, "--height", "200",
                         "--cameras", "1", "--format", "png"})
                  .exit_code,
              0);
  }
  const Outcome none = calibrate(file("a") + "/cam1");
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_THAT(none.err, HasSubstr("cam1: the board is in 0 of"));
  EXPECT_THAT(none.err, HasSubstr("is it charuco:8x5:40mm:30mm:5X5_100, sharp, evenly lit"));
  fs::copy_file(file("b") + "/cam1/000000.png", file("a") + "/cam1/000900.png");
  const Outcome mixed = calibrate(file("a") + "/cam1");
  EXPECT_EQ(mixed.exit_code, 1);
  EXPECT_THAT(mixed.err, HasSubstr("not all of one camera are of the same size"));
  EXPECT_THAT(mixed.err, HasSubstr("000900.png"));
}

TEST_F(CalibrateIntrinsics, ExistingFilesStay) {
  scratch_.write("lens.toml", "precious");
  const Outcome refused = calibrate("sim");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_THAT(refused.err, HasSubstr("exists already; --force replaces it"));
  EXPECT_EQ(text_of(file("lens.toml")), "precious");
}

TEST_F(CalibrateIntrinsics, WrongCommandLines) {
  const auto said = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"calibrate", "intrinsics"});
    arguments.insert(arguments.end(), {"--output", file("x.toml")});
    const Outcome outcome = run_glint(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << outcome.err;
    return outcome.err;
  };
  EXPECT_THAT(said({"sim"}), HasSubstr("--board is needed"));
  EXPECT_THAT(said({"--board", kBoard}), HasSubstr("give a SOURCE of pictures, or --from FILE"));
  EXPECT_THAT(said({"sim", "--board", "chessboard:9x6"}), HasSubstr("needs two things after chessboard:"));
  EXPECT_THAT(said({"sim", "--board", kBoard, "--model", "rational"}),
              HasSubstr("rational model of 8 coefficients is not supported"));
  EXPECT_THAT(said({"v4l2:", "--board", kBoard}), HasSubstr("needs devices"));
}

TEST(CalibrateBoard, WritesPagesAndRefusesWhatDoesNotFit) {
  const TempDir scratch;
  const std::string svg = (scratch.path() / "b.svg").string(), pdf = (scratch.path() / "b.pdf").string();
  const Outcome written = run_glint({"calibrate", "board", "chessboard:9x6:25mm", "--output", svg});
  EXPECT_EQ(written.exit_code, 0) << written.err;
  EXPECT_THAT(written.out, HasSubstr("--board chessboard:9x6:25mm"));
  EXPECT_EQ(run_glint({"calibrate", "board", "chessboard:9x6:25mm", "--output", pdf}).exit_code, 0);
  EXPECT_GT(fs::file_size(pdf), 1000u);
  EXPECT_EQ(run_glint({"calibrate", "board", "chessboard:9x6:25mm", "--output", pdf}).exit_code, 1)
      << "exists";
  const Outcome large = run_glint({"calibrate", "board", "chessboard:9x6:50mm", "-o", svg, "--force"});
  EXPECT_EQ(large.exit_code, 1);
  EXPECT_THAT(large.err, HasSubstr("needs a page of 516 x 380 mm"));
  EXPECT_EQ(run_glint({"calibrate", "board", "chessboard:9x6:25mm", "-o", svg + ".png"}).exit_code, 2);
  EXPECT_EQ(run_glint({"calibrate", "board", "chessboard:9x6:25", "-o", pdf, "--force"}).exit_code, 2);
}

}  // namespace
}  // namespace glint::test
