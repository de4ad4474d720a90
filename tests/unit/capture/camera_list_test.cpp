// SPDX-License-Identifier: MIT
// Who is who among the cameras, whatever their numbers.
#include "host/capture/v4l2/camera_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/capture/camera_stream_fixture.hpp"
#include "tests/unit/capture/fake_sysfs.hpp"

namespace glint {
namespace {

using test::error_of;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class Cameras : public ::testing::Test {
 protected:
  std::string opened(const std::string& device) {
    return open_camera(driver_, tree_.roots(), device).identity.node;
  }
  std::string refusal(const std::string& device) {
    return error_of([&] { (void)open_camera(driver_, tree_.roots(), device); });
  }
  void add_usb(unsigned number, const std::string& port, const std::string& serial) {
    tree_.add_usb(number, port, serial, true);
    driver_.add(tree_.node(number)).card = "Camera " + port;
    driver_.add(tree_.node(number + 1)).abilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
  }

  test::FakeSysfs tree_;
  test::FakeV4l2 driver_;
};

TEST_F(Cameras, NamesAreThoseOfUdev) {
  tree_.add_usb(0, "1-2.3", "UC762", true);
  tree_.add_platform(4, "vivid.0", 0);
  tree_.add_platform(5, "vivid.0", 1);
  tree_.add_virtual(40);
  const auto all = list_identities(tree_.roots());
  ASSERT_EQ(all.size(), 5u);
  EXPECT_EQ(all[0].by_path, "pci-0000:00:14.0-usb-0:2.3:1.0-video-index0");
  EXPECT_EQ(all[1].by_path, "pci-0000:00:14.0-usb-0:2.3:1.0-video-index1");
  EXPECT_EQ(all[2].by_path, "platform-vivid.0-video-index0");
  EXPECT_EQ(all[3].by_path, "platform-vivid.0-video-index1");
  EXPECT_EQ(all[4].by_path, "");
  EXPECT_EQ(all[4].stable_name(), tree_.node(40));
  ASSERT_TRUE(all[0].usb);
  EXPECT_EQ(all[0].usb->port, "1-2.3");
  EXPECT_EQ(all[0].usb->bus, 1u);
  EXPECT_EQ(all[0].usb->speed_mbit_s, 480.0);
  EXPECT_EQ(all[0].usb->serial, "UC762");
  EXPECT_FALSE(all[2].usb);
}

TEST_F(Cameras, NothingInASerialNumberActsOnATerminal) {
  add_usb(0, "1-1", "\x1b[2JA\xff");
  const auto all = list_identities(tree_.roots());
  ASSERT_TRUE(all.at(0).usb);
  EXPECT_EQ(all[0].usb->serial, "?[2JA?");
  EXPECT_EQ(opened("serial:?[2JA?"), tree_.node(0));
}

TEST_F(Cameras, ANameOfSeveralNodesIsNone) {
  tree_.add_platform(0, "vivid.0", 0);
  tree_.add_platform(1, "vivid.0", 0);  // vivid numbers the nodes of each of its cameras from 0
  driver_.add(tree_.node(0));
  driver_.add(tree_.node(1));
  for (const DeviceIdentity& identity : list_identities(tree_.roots())) EXPECT_EQ(identity.by_path, "");
  EXPECT_EQ(opened(tree_.node(1)), tree_.node(1));
}

TEST_F(Cameras, UdevsOwnLinkHasTheLastWord) {
  tree_.add_usb(0, "1-2", "");
  tree_.link_by_path("pci-0000:00:14.0-usbv2-0:2:1.0-video-index0", 0);
  EXPECT_EQ(list_identities(tree_.roots())[0].by_path, "pci-0000:00:14.0-usbv2-0:2:1.0-video-index0");
}

TEST_F(Cameras, AreFoundByEveryName) {
  add_usb(0, "1-2", "A1");
  add_usb(2, "1-4", "B2");
  EXPECT_EQ(opened("usb:1-4"), tree_.node(2));
  EXPECT_EQ(opened("serial:A1"), tree_.node(0));
  EXPECT_EQ(opened("pci-0000:00:14.0-usb-0:4:1.0-video-index0"), tree_.node(2));
  EXPECT_EQ(opened((tree_.roots().dev / "v4l/by-path/pci-0000:00:14.0-usb-0:4:1.0-video-index0").string()),
            tree_.node(2))
      << "even where udev makes no links";
  EXPECT_EQ(opened(tree_.node(0)), tree_.node(0));
}

TEST_F(Cameras, WhatIsNotThereIsListed) {
  add_usb(0, "1-2", "A1");
  EXPECT_THAT(refusal("usb:1-9"),
              HasSubstr("\"usb:1-9\" is not there; connected are: pci-0000:00:14.0-usb-0:2:1.0"));
  EXPECT_THROW((void)open_camera(driver_, tree_.roots(), "serial:A"), NoSuchCamera);
  EXPECT_THROW((void)open_camera(driver_, tree_.roots(), "/dev/no-such-video"), NoSuchCamera);
  EXPECT_THAT(refusal(tree_.node(1)), HasSubstr("gives no pictures"));
}

TEST_F(Cameras, OneSerialOfTwoCamerasIsRefused) {
  add_usb(0, "1-2", "UC762");
  add_usb(2, "1-4", "UC762");
  EXPECT_THAT(refusal("serial:UC762"),
              HasSubstr("is more than one camera: pci-0000:00:14.0-usb-0:2:1.0-video-index0 and pci-0000"));
}

TEST_F(Cameras, TheListTellsBusesAndSkipsWhatIsNoCamera) {
  add_usb(0, "1-2", "A1");
  add_usb(2, "1-4", "B2");
  add_usb(4, "3-1", "C3");
  driver_.add(tree_.node(4)).open_error = EACCES;
  const CameraList list = list_cameras(driver_, tree_.roots());
  ASSERT_EQ(list.cameras.size(), 3u);
  EXPECT_EQ(list.problem, "");
  EXPECT_EQ(list.cameras[0].card, "Camera 1-2");
  EXPECT_THAT(list.cameras[0].bus_neighbours, ElementsAre(tree_.node(2)));
  EXPECT_THAT(list.cameras[1].bus_neighbours, ElementsAre(tree_.node(0)));
  EXPECT_THAT(list.cameras[2].bus_neighbours, ElementsAre());
  EXPECT_EQ(describe(list.cameras[0].formats), "GREY 64x48 at 100 Hz");
  EXPECT_THAT(list.cameras[2].problem, HasSubstr("group video"));
}

TEST_F(Cameras, NoneAtAll) {
  EXPECT_THAT(list_cameras(driver_, tree_.roots()).problem, HasSubstr("no camera is connected"));
  EXPECT_THAT(list_cameras(driver_, {"/nonexistent/dev", "/nonexistent/sys"}).problem,
              HasSubstr("no camera is connected"));
}

}  // namespace
}  // namespace glint
