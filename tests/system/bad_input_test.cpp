// SPDX-License-Identifier: MIT
// Whatever is wrong is said in one message that names it, with exit code 2 for the command line and 1 for the
// rest.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "tests/support/temp_dir.hpp"
#include "tests/system/run_glint.hpp"

namespace glint::test {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
namespace fs = std::filesystem;

/// A short recording of the simulated rig, made once.
class BadInput : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TempDir;
    ASSERT_EQ(run_glint({"sim", "--out", take().string(), "--seconds", "0.1", "--width", "320", "--height",
                         "200", "--format", "png"})
                  .exit_code,
              0);
  }
  static void TearDownTestSuite() {
    delete folder_;
    folder_ = nullptr;
  }
  static fs::path take() { return folder_->path() / "take"; }
  static std::string calibration() { return (take() / "calibration.toml").string(); }

  static std::string calibration_text() {
    std::ifstream file(calibration());
    return {std::istreambuf_iterator<char>(file), {}};
  }
  /// The calibration with its first `from` replaced.
  std::string rig_with(const std::string& from, const std::string& to) const {
    std::string text = calibration_text();
    const auto at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    return scratch_.write("rig.toml", text).string();
  }
  Outcome track(const std::string& rig, std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments{"track", "images:" + take().string(), "--rig", rig, "--device", "cpu"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_glint(arguments);
  }
  /// A copy of the recording that may be spoilt.
  fs::path copy_of_take() const {
    const fs::path copy = scratch_.path() / "copy";
    fs::copy(take(), copy, fs::copy_options::recursive);
    return copy;
  }
  TempDir scratch_;
  static TempDir* folder_;
};
TempDir* BadInput::folder_ = nullptr;

TEST_F(BadInput, GoodInputPasses) { EXPECT_EQ(track(calibration()).exit_code, 0); }

TEST_F(BadInput, MissingRigFile) {
  const Outcome o = track("no-such.toml");
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("no-such.toml"));
}

TEST_F(BadInput, NoRigAtAll) {
  const Outcome o = run_glint({"track", "images:" + take().string()});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, HasSubstr("--rig"));
}

TEST_F(BadInput, UnknownKeyWrongTypeAndSingularPoseAreListedTogether) {
  std::string text = calibration_text();
  text.replace(text.find("fx_px"), 5, "fx_py");
  text.replace(text.find("height_px = 200"), 15, "height_px = \"x\"");
  const auto at = text.find("qx = ");
  ASSERT_NE(at, std::string::npos);
  const auto end = text.find('}', at);
  text.replace(at, end - at, "qx = 0.0, qy = 0.0, qz = 0.0, qw = 0.0 ");
  const Outcome o = track(scratch_.write("rig.toml", text).string());
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("rig.toml:"));
  EXPECT_THAT(o.err, HasSubstr("fx_py"));
  EXPECT_THAT(o.err, HasSubstr("height_px"));
  EXPECT_THAT(o.err, HasSubstr("quaternion"));
}

TEST_F(BadInput, ZeroCameras) {
  const Outcome o = track(scratch_.write("rig.toml", "format = 1\nkind = \"calibration\"\n").string());
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("camera"));
}

TEST_F(BadInput, CameraNamesThatDoNotMatchTheSource) {
  const Outcome o = track(rig_with("name = \"cam2\"", "name = \"north\""));
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("north"));
  EXPECT_THAT(o.err, HasSubstr("cam2"));
}

TEST_F(BadInput, FramesOfAnotherSizeThanTheRigSays) {
  const Outcome o = track(rig_with("width_px = 320", "width_px = 640"));
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("640x200"));
  EXPECT_THAT(o.err, HasSubstr("320x200"));
}

TEST_F(BadInput, TruncatedImageIsCountedNamedAndTheRestIsTracked) {
  const fs::path copy = copy_of_take();
  fs::path victim;
  for (const auto& entry : fs::directory_iterator(copy / "cam3")) victim = std::max(victim, entry.path());
  fs::resize_file(victim, fs::file_size(victim) / 2);
  const std::string csv = (scratch_.path() / "out.csv").string();
  const Outcome o = run_glint({"track", "images:" + copy.string(), "--rig", calibration(), "--device", "cpu",
                               "--background", "none", "--threshold", "14", "--output", "csv:" + csv});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr(victim.filename().string()));
  EXPECT_THAT(o.err, HasSubstr("1 damaged"));
  EXPECT_GT(fs::file_size(csv), 200u);
}

TEST_F(BadInput, ACameraThatEndsEarlyIsNamed) {
  const fs::path copy = copy_of_take();
  fs::path last;
  for (const auto& entry : fs::directory_iterator(copy / "cam2")) last = std::max(last, entry.path());
  fs::remove(last);
  const Outcome o =
      run_glint({"track", "images:" + copy.string(), "--rig", calibration(), "--device", "cpu"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("cam2 ended after"));
}

TEST_F(BadInput, NoVulkanDriver) {
  const Outcome o =
      run_glint({"track", "sim", "--ticks", "1"},
                {.environment = {"VK_DRIVER_FILES=/nonexistent.json", "VK_ICD_FILENAMES=/nonexistent.json"},
                 .interrupt_after_s = 0.0,
                 .standard_output = {}});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("no Vulkan"));
  EXPECT_THAT(o.err, HasSubstr("--device cpu"));
}

TEST_F(BadInput, UnknownDeviceListsWhatThereIs) {
  const Outcome o = run_glint({"track", "sim", "--ticks", "1", "--device", "voodoo"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("voodoo"));
  EXPECT_THAT(o.err, HasSubstr("cpu"));
}

TEST_F(BadInput, UnwritableOutput) {
  const Outcome o = track(calibration(), {"--output", "csv:/nonexistent/out.csv"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("/nonexistent/out.csv"));
}

TEST_F(BadInput, AnExistingOutputIsKept) {
  const std::string file = scratch_.write("kept.csv", "precious\n").string();
  const Outcome o = track(calibration(), {"--output", "csv:" + file});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("kept.csv"));
  EXPECT_EQ(fs::file_size(file), 9u);
}

TEST_F(BadInput, AFullDiskEndsTheRunAndSaysSo) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "SKIPPED: no /dev/full";
  const Outcome o = track(calibration(), {"--output", "jsonl:/dev/full", "--force"});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("No space left"));
}

TEST_F(BadInput, ARigThatIsNotTheSimulatedOne) {
  const Outcome o = run_glint(
      {"track", "sim", "--rig", calibration(), "--cameras", "2", "--ticks", "1", "--device", "cpu"});
  EXPECT_EQ(o.exit_code, 2);
  EXPECT_THAT(o.err, HasSubstr("--cameras"));
}

TEST_F(BadInput, AVeryShortRunStillEnds) {
  const Outcome o =
      run_glint({"track", "sim", "--ticks", "5", "--seconds", "0.001", "--device", "cpu", "--pace", "fast"});
  EXPECT_EQ(o.exit_code, 0) << o.err;
  EXPECT_THAT(o.err, HasSubstr("0 of 1"));
}

TEST_F(BadInput, CtrlCBeforeTheRunBeginsEndsTheProgram) {
  const Outcome o = run_glint({"track", "sim", "--background", "1000", "--jpeg", "90", "--device", "cpu"},
                              {.environment = {}, .interrupt_after_s = 1.0, .standard_output = {}});
  EXPECT_EQ(o.exit_code, 130);
}

TEST_F(BadInput, UsageErrorsAreCode2) {
  EXPECT_EQ(run_glint({"track"}).exit_code, 2);
  EXPECT_EQ(run_glint({"track", "cameras"}).exit_code, 2);
  EXPECT_EQ(run_glint({"track", "sim", "--bogus"}).exit_code, 2);
  EXPECT_EQ(run_glint({"track", "sim", "--output", "xml:f"}).exit_code, 2);
  EXPECT_EQ(run_glint({"track", "sim", "--markers", "-3"}).exit_code, 2);
  EXPECT_EQ(run_glint({"no-such-command"}).exit_code, 2);
}

TEST_F(BadInput, BlobFileErrorsNameTheLine) {
  scratch_.write("blobs/cam1.csv", "tick,x_px,y_px\n1,10,10\n2,abc,5\n");
  for (const char* name : {"cam2", "cam3", "cam4"})
    scratch_.write(std::string("blobs/") + name + ".csv", "tick,x_px,y_px\n1,10,10\n");
  const Outcome o =
      run_glint({"track", "blobs:" + (scratch_.path() / "blobs").string(), "--rig", calibration()});
  EXPECT_EQ(o.exit_code, 1);
  EXPECT_THAT(o.err, HasSubstr("cam1.csv:3:"));
}

}  // namespace
}  // namespace glint::test
