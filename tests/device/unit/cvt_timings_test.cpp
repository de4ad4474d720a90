// SPDX-License-Identifier: MIT
// Timings of 1280x800 pixels against VESA's published ones.
#include <gtest/gtest.h>

#include "tests/device/vivid_faults/vivid_device.hpp"

namespace glint::device {
namespace {

// VESA DMT 1.13, 1280x800 at 60 Hz.
TEST(CvtTimings, At60HzAreThePublishedOnes) {
  const v4l2_bt_timings bt = cvt_timings(60.0);
  EXPECT_EQ(bt.pixelclock, 83'500'000u);
  EXPECT_EQ(bt.hfrontporch, 72u);
  EXPECT_EQ(bt.hsync, 128u);
  EXPECT_EQ(bt.hbackporch, 200u);
  EXPECT_EQ(bt.vfrontporch, 3u);
  EXPECT_EQ(bt.vsync, 6u);
  EXPECT_EQ(bt.vbackporch, 22u);
}

TEST(CvtTimings, AreNeverFasterThanAskedForAndHardlySlower) {
  for (const double rate_hz : {30.0, 60.0, 90.0, 100.0, 120.0}) {
    const v4l2_bt_timings bt = cvt_timings(rate_hz);
    const double total = static_cast<double>(bt.width + bt.hfrontporch + bt.hsync + bt.hbackporch) *
                         (bt.height + bt.vfrontporch + bt.vsync + bt.vbackporch);
    const double got_hz = static_cast<double>(bt.pixelclock) / total;
    EXPECT_LE(got_hz, rate_hz * 1.001);
    EXPECT_GE(got_hz, rate_hz * 0.99);
  }
}

}  // namespace
}  // namespace glint::device
