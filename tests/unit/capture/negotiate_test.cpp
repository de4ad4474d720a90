// SPDX-License-Identifier: MIT
// Formats, sizes and rates: exactly what was asked for, or what there is instead.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/capture/camera_stream_fixture.hpp"

namespace glint {
namespace {

using test::error_of;
using test::FakeFormat;
using test::FakeSize;
using ::testing::HasSubstr;
using ::testing::Not;

class Negotiation : public ::testing::Test, protected test::StreamFixture {
 protected:
  Negotiation() {
    camera().formats = {
        {V4L2_PIX_FMT_YUYV, {FakeSize{1280, 800, {10.0}}, FakeSize{640, 400, {60.0, 30.0}}}},
        {V4L2_PIX_FMT_MJPEG, {FakeSize{1280, 800, {120.0, 100.0, 90.0, 60.0}}, FakeSize{640, 400, {240.0}}}},
        {V4L2_PIX_FMT_UYVY, {FakeSize{320, 200, {500.0}}}}};
  }
  AgreedFormat agree(std::optional<PixelKind> kind, FrameSize size, double rate_hz) {
    DeviceNode node(driver_, path_.c_str());
    return negotiate(node, {kind, size, rate_hz});
  }
  std::string refusal(std::optional<PixelKind> kind, FrameSize size, double rate_hz) {
    return error_of([&] { (void)agree(kind, size, rate_hz); });
  }
};

TEST_F(Negotiation, TakesTheFormatThatReachesTheRate) {
  const AgreedFormat fast = agree(std::nullopt, {1280, 800}, 90.0);
  EXPECT_EQ(fast.kind, PixelKind::Mjpeg);
  EXPECT_EQ(fast.size.width_px, 1280u);
  EXPECT_DOUBLE_EQ(fast.rate_hz, 90.0);
  EXPECT_EQ(agree(std::nullopt, {1280, 800}, 10.0).kind, PixelKind::Yuyv) << "raw before compressed";
  EXPECT_EQ(agree(std::nullopt, {640, 400}, 240.0).kind, PixelKind::Mjpeg);
}

TEST_F(Negotiation, EveryOfferedCombinationAndNoOther) {
  for (const PixelKind kind : {PixelKind::Grey, PixelKind::Nv12, PixelKind::Yuyv, PixelKind::Mjpeg}) {
    for (const FrameSize size : {FrameSize{1280, 800}, {640, 400}, {320, 200}, {1280, 720}}) {
      for (const double rate : {10.0, 30.0, 60.0, 90.0, 100.0, 120.0, 240.0, 500.0}) {
        bool offered = false;
        for (const FakeFormat& format : camera().formats) {
          const bool same = (format.fourcc == V4L2_PIX_FMT_YUYV && kind == PixelKind::Yuyv) ||
                            (format.fourcc == V4L2_PIX_FMT_MJPEG && kind == PixelKind::Mjpeg);
          for (const FakeSize& s : format.sizes) {
            offered |= same && s.width_px == size.width_px && s.height_px == size.height_px &&
                       std::count(s.rates_hz.begin(), s.rates_hz.end(), rate) > 0;
          }
        }
        const std::string problem = refusal(kind, size, rate);
        EXPECT_EQ(problem.empty(), offered)
            << name_of(kind) << ' ' << size.width_px << ' ' << rate << ' ' << problem;
      }
    }
  }
}

TEST_F(Negotiation, ARefusalListsWhatThereIs) {
  const std::string problem = refusal(PixelKind::Yuyv, {1280, 800}, 90.0);
  EXPECT_THAT(problem, HasSubstr("does not offer yuyv 1280x800 at 90 Hz"));
  EXPECT_THAT(problem, HasSubstr("YUYV 1280x800 at 10 Hz"));
  EXPECT_THAT(problem, HasSubstr("MJPG 1280x800 at 120, 100, 90, 60 Hz"));
  EXPECT_THAT(problem, Not(HasSubstr("UYVY"))) << "glint cannot read it";
  EXPECT_THAT(refusal(PixelKind::Grey, {320, 200}, 90.0), Not(HasSubstr("nothing")));
  camera().formats = {{V4L2_PIX_FMT_UYVY, {FakeSize{320, 200, {500.0}}}}};
  EXPECT_THAT(refusal(std::nullopt, {320, 200}, 500.0), HasSubstr("it offers: nothing that glint can read"));
}

TEST_F(Negotiation, ARateNearbyWillDoWhereTimingsAreNotRound) {
  camera().formats = {{V4L2_PIX_FMT_GREY, {FakeSize{64, 48, {89.73}}}}};
  EXPECT_NEAR(agree(std::nullopt, {64, 48}, 90.0).rate_hz, 89.73, 1e-9);
  EXPECT_THAT(refusal(std::nullopt, {64, 48}, 92.0), HasSubstr("89.73"));
}

TEST_F(Negotiation, ADriverThatListsNothingIsAskedDirectly) {
  camera().formats = {{V4L2_PIX_FMT_GREY, {}}};
  EXPECT_EQ(agree(PixelKind::Grey, {64, 48}, 0.0).size.height_px, 48u);
}

TEST_F(Negotiation, ADriverThatCannotSetTheRate) {
  camera().sets_rate = false;
  camera().set_rate_hz = 60.0;
  EXPECT_DOUBLE_EQ(agree(PixelKind::Mjpeg, {1280, 800}, 60.0).rate_hz, 60.0);
  EXPECT_THAT(refusal(PixelKind::Mjpeg, {1280, 800}, 120.0), HasSubstr("the driver would give 60 Hz"));
  camera().answers[VIDIOC_G_PARM] = {ENOTTY};
  EXPECT_DOUBLE_EQ(agree(PixelKind::Mjpeg, {1280, 800}, 120.0).rate_hz, 0.0) << "a trigger sets the pace";
}

TEST_F(Negotiation, ADriverThatCanDoMoreThanItLists) {
  camera().formats = {{V4L2_PIX_FMT_GREY, {FakeSize{64, 48, {100.0}}}}};
  camera().hidden_rate_hz = 90.0;
  EXPECT_DOUBLE_EQ(agree(std::nullopt, {64, 48}, 90.0).rate_hz, 90.0);
  EXPECT_DOUBLE_EQ(agree(std::nullopt, {64, 48}, 100.0).rate_hz, 100.0);
}

TEST_F(Negotiation, SizesInSteps) {
  camera().formats = {{V4L2_PIX_FMT_GREY, {FakeSize{64, 48, {}}, FakeSize{1920, 1080, {}}}, true}};
  EXPECT_EQ(agree(std::nullopt, {1280, 800}, 0.0).size.width_px, 1280u);
  EXPECT_THAT(refusal(std::nullopt, {1281, 800}, 0.0), HasSubstr("GREY 64x48 to 1920x1080"));
}

TEST_F(Negotiation, TheDriversOwnSizeIfNoneIsAskedFor) {
  EXPECT_EQ(agree(PixelKind::Yuyv, {}, 10.0).size.width_px, 1280u);
}

TEST_F(Negotiation, BusyAndBroken) {
  camera().answers[VIDIOC_S_FMT] = {EBUSY, EBUSY, EBUSY};
  EXPECT_THAT(refusal(PixelKind::Mjpeg, {1280, 800}, 90.0), HasSubstr("another program uses it"));
  camera().answers[VIDIOC_S_FMT] = {EIO};
  EXPECT_THAT(refusal(PixelKind::Mjpeg, {1280, 800}, 90.0), HasSubstr("Input/output error"));
  camera().answers[VIDIOC_S_FMT].clear();
  camera().answers[VIDIOC_S_PARM] = {EBUSY};
  EXPECT_THAT(refusal(PixelKind::Mjpeg, {1280, 800}, 90.0), HasSubstr("a rate of 90 Hz was refused"));
  camera().answers[VIDIOC_G_FMT] = {ENODEV};
  EXPECT_THAT(refusal(PixelKind::Mjpeg, {}, 90.0), HasSubstr("cannot be read"));
}

TEST_F(Negotiation, TheErrorNamesCameraAndNode) {
  CameraRequest wanted = request();
  wanted.format = {PixelKind::Grey, {64, 48}, 100.0};
  const std::string problem = error_of([&] { start(wanted); });
  EXPECT_THAT(problem,
              ::testing::StartsWith("camera left (" + path_ + "): does not offer grey 64x48 at 100 Hz"));
}

}  // namespace
}  // namespace glint
