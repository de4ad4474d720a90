// SPDX-License-Identifier: MIT
// What fits through a bus.
#include "host/doctor/usb_checks.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/doctor/fake_rig.hpp"

namespace glint {
namespace {

using ::testing::HasSubstr;

class UsbChecks : public ::testing::Test, protected test::FakeRig {
 protected:
  Findings check(const std::vector<CameraRequest>& wanted = {}) {
    return check_usb(list(), tree_.roots(), wanted);
  }
};

TEST_F(UsbChecks, NothingToSayWithoutUsbCameras) {
  EXPECT_TRUE(check().empty());
  tree_.add_virtual(9);
  driver_.add(tree_.node(9));
  EXPECT_TRUE(check().empty());
}

TEST_F(UsbChecks, CamerasThatShareABusAreToldOf) {
  add(0, "1-1");
  add(2, "1-2");
  add(4, "3-1");
  const Findings findings = check();
  ASSERT_EQ(findings.size(), 2u);
  EXPECT_EQ(findings[0].verdict, Verdict::Warning);
  EXPECT_THAT(findings[0].text, HasSubstr("bus 1: " + tree_.node(0) + ", " + tree_.node(2)));
  EXPECT_THAT(findings[0].advice, HasSubstr("lsusb -t"));
  EXPECT_EQ(findings[1].verdict, Verdict::Ok);
}

TEST_F(UsbChecks, FourMjpegCamerasFit) {
  std::vector<CameraRequest> wanted;
  for (unsigned n = 1; n <= 4; ++n) {
    const std::string port = "1-" + std::to_string(n);
    add(2 * n, port);
    wanted.push_back(request(port, std::nullopt, 90.0));
  }
  const Findings findings = check(wanted);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].verdict, Verdict::Warning) << findings[0].text;
  EXPECT_THAT(findings[0].text, HasSubstr("295 Mbit/s of 384 Mbit/s"));
}

TEST_F(UsbChecks, RawPicturesDoNot) {
  add(0, "1-1").formats = {{V4L2_PIX_FMT_GREY, {test::FakeSize{1280, 800, {90.0, 10.0}}}}};
  const Findings one = check({request("1-1", std::nullopt, 90.0)});
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].verdict, Verdict::Problem);
  EXPECT_THAT(one[0].text, HasSubstr("737 Mbit/s"));
  EXPECT_THAT(one[0].advice, HasSubstr("mjpeg"));
  EXPECT_EQ(check({request("1-1", std::nullopt, 10.0)}).at(0).verdict, Verdict::Ok);
}

TEST_F(UsbChecks, ManyThatFitAloneDoNotFitTogether) {
  std::vector<CameraRequest> wanted;
  for (unsigned n = 1; n <= 5; ++n) {
    const std::string port = "1-" + std::to_string(n);
    add(2 * n, port).formats = {{V4L2_PIX_FMT_GREY, {test::FakeSize{1280, 800, {20.0}}}}};
    wanted.push_back(request(port, std::nullopt, 20.0));  // 164 Mbit/s each
  }
  const Findings findings = check(wanted);
  ASSERT_EQ(findings.size(), 1u);
  EXPECT_EQ(findings[0].verdict, Verdict::Problem);
  EXPECT_THAT(findings[0].text, HasSubstr("819 Mbit/s of 384 Mbit/s"));
}

TEST(StreamBits, CountWhatAPixelHas) {
  const FrameSize size{1000, 1000};
  EXPECT_DOUBLE_EQ(stream_bit_s(PixelKind::Grey, size, 10.0), 80e6);
  EXPECT_DOUBLE_EQ(stream_bit_s(PixelKind::Nv12, size, 10.0), 120e6);
  EXPECT_DOUBLE_EQ(stream_bit_s(PixelKind::Yuyv, size, 10.0), 160e6);
  EXPECT_LT(stream_bit_s(PixelKind::Mjpeg, size, 10.0), 20e6);
}

}  // namespace
}  // namespace glint
