// SPDX-License-Identifier: MIT
// Cameras that are missing, locked up, or not what the rig wants.
#include "host/doctor/camera_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <filesystem>

#include "tests/unit/doctor/fake_rig.hpp"

namespace glint {
namespace {

using test::FakeCamera;
using test::FakeControl;
using ::testing::HasSubstr;
using ::testing::Not;

class CameraChecks : public ::testing::Test, protected test::FakeRig {
 protected:
  Findings cameras() { return check_cameras(list(), tree_.roots()); }
  Finding wanted(const CameraRequest& request) {
    const Findings findings = check_wanted(driver_, tree_.roots(), {request});
    EXPECT_EQ(findings.size(), 1u);
    EXPECT_EQ(driver_.open_nodes(), 0);
    return findings.at(0);
  }
};

TEST_F(CameraChecks, NoCameraIsAProblem) {
  const Findings findings = cameras();
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].verdict, Verdict::Problem);
  EXPECT_THAT(findings[0].advice, HasSubstr("lsusb"));
  EXPECT_THAT(findings[0].advice, Not(HasSubstr("modprobe")));
}

TEST_F(CameraChecks, AKernelWithoutVideoIsToldApart) {
  std::filesystem::remove_all(tree_.roots().sys);
  EXPECT_THAT(cameras().at(0).advice, HasSubstr("modprobe uvcvideo"));
}

TEST_F(CameraChecks, OneThatMayNotBeOpenedIsNamedBesideTheOthers) {
  add(0, "1-1");
  add(2, "1-2", true).open_error = EACCES;
  driver_.add(tree_.node(3)).open_error = EACCES;  // its metadata
  const Findings findings = cameras();
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].verdict, Verdict::Ok);
  EXPECT_THAT(findings[0].text, HasSubstr(tree_.node(0)));
  EXPECT_EQ(findings[1].verdict, Verdict::Problem);
  EXPECT_THAT(findings[1].text, HasSubstr(tree_.node(2)));
  EXPECT_THAT(findings[1].text, HasSubstr("group video"));
  EXPECT_THAT(findings[1].advice, HasSubstr("mode 06"));
}

TEST_F(CameraChecks, ANodeThatIsMissingPointsToContainers) {
  add(0, "1-1").open_error = ENOENT;
  std::filesystem::remove(tree_.node(0));
  EXPECT_THAT(cameras().at(0).advice, HasSubstr("container"));
}

TEST_F(CameraChecks, TheRigsCameraIsFoundWithItsFormat) {
  add(0, "1-1");
  const Finding finding = wanted(request("1-1", std::nullopt, 90.0));
  EXPECT_EQ(finding.verdict, Verdict::Ok) << finding.text;
  EXPECT_THAT(finding.text, HasSubstr("mjpeg 1280x800 at 90 Hz"));
  EXPECT_EQ(wanted(request("1-1", PixelKind::Grey, 10.0)).verdict, Verdict::Ok);
}

TEST_F(CameraChecks, AFormatThatIsNotListedSaysWhatIs) {
  add(0, "1-1");
  const Finding finding = wanted(request("1-1", PixelKind::Grey, 90.0));
  EXPECT_EQ(finding.verdict, Verdict::Problem);
  EXPECT_THAT(finding.text, HasSubstr("does not list grey 1280x800 at 90 Hz"));
  EXPECT_THAT(finding.advice, HasSubstr("GREY 1280x800 at 10 Hz"));
}

TEST_F(CameraChecks, AMissingCameraListsThoseThatAreThere) {
  add(0, "1-1");
  const Finding finding = wanted(request("1-7", std::nullopt, 90.0));
  EXPECT_EQ(finding.verdict, Verdict::Problem);
  EXPECT_THAT(finding.text, HasSubstr("usb:1-7"));
  EXPECT_THAT(finding.text, HasSubstr("connected are"));
}

TEST_F(CameraChecks, ControlsAreCheckedByNameAndRange) {
  FakeControl gain;
  gain.id = V4L2_CID_GAIN;
  gain.name = "Gain";
  add(0, "1-1").controls = {gain};
  CameraRequest camera = request("1-1", std::nullopt, 90.0);
  camera.controls = {{"gain", std::int64_t{100}}};
  EXPECT_EQ(wanted(camera).verdict, Verdict::Ok);
  camera.controls = {{"gain", std::int64_t{101}}, {"sharpness", std::int64_t{1}}};
  const Finding finding = wanted(camera);
  EXPECT_EQ(finding.verdict, Verdict::Problem);
  EXPECT_THAT(finding.text, HasSubstr("gain must be 0 to 100"));
  EXPECT_THAT(finding.text, HasSubstr("sharpness is unknown"));
  driver_.with(tree_.node(0),
               [](FakeCamera& fake) { EXPECT_EQ(fake.controls[0].value, 50) << "only looked at"; });
}

}  // namespace
}  // namespace glint
