// SPDX-License-Identifier: MIT
// From the driver's buffers to frame sets nothing is allocated, whatever the pixels come as.
#include <gtest/gtest.h>

#include <string>

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>

#include "host/capture/v4l2/v4l2_source.hpp"
#include "tests/support/allocations.hpp"
#include "tests/unit/capture/camera_stream_fixture.hpp"
#include "tests/unit/capture/grey_jpeg.hpp"

namespace glint {
namespace {

/// Eight pictures of which one is cut short.
void give_jpegs(test::FakeCamera& camera) {
  std::vector<std::vector<std::uint8_t>> jpegs;
  for (unsigned n = 0; n < 8; ++n)
    jpegs.push_back(test::jpeg_of(test::disc_picture(64, 48, n), 64, 48, 90, true));
  jpegs.back().resize(jpegs.back().size() / 2);
  camera.formats = {{V4L2_PIX_FMT_MJPEG, {test::FakeSize{}}}};
  camera.frame = [jpegs](std::uint64_t pulse, test::FakeFrame& frame) {
    frame.bytes.assign(jpegs[pulse % 8].begin(), jpegs[pulse % 8].end());
    return true;
  };
}

TEST(V4l2NoAllocation, OneStream) {
  for (const auto& [fourcc, with_limit] : {std::pair{V4L2_PIX_FMT_GREY, false},
                                           {V4L2_PIX_FMT_YUYV, false},
                                           {V4L2_PIX_FMT_NV12, false},
                                           {V4L2_PIX_FMT_MJPEG, false},
                                           {V4L2_PIX_FMT_MJPEG, true}}) {
    test::StreamFixture fixture;
    fixture.camera().formats = {{fourcc, {test::FakeSize{}}}};
    fixture.camera().takes_pointers = true;
    fixture.camera().frame = [](std::uint64_t, test::FakeFrame& frame) {
      frame.bytes.assign(64 * 48 * 2, 3);
      return true;
    };
    if (fourcc == V4L2_PIX_FMT_MJPEG) give_jpegs(fixture.camera());
    fixture.start();
    for (int n = 0; n < 40; ++n) ASSERT_EQ(fixture.next_frame(), StreamStatus::Frame);
    if (with_limit) {
      fixture.stream_->stop();
      fixture.stream_->set_limit(std::vector<std::uint8_t>(64 * 48, 40));
      fixture.received_.frame = {};
      fixture.stream_->start(*fixture.pool_, CameraId{0});
    }
    const std::size_t before = testing::allocations();
    const std::size_t heap_before = testing::heap_bytes();
    for (int n = 0; n < 400; ++n) ASSERT_EQ(fixture.next_frame(), StreamStatus::Frame);
    EXPECT_EQ(testing::allocations() - before, 0u) << fourcc;
    EXPECT_EQ(testing::heap_bytes(), heap_before) << fourcc;
  }
}

TEST(V4l2NoAllocation, TheWholeSource) {
  test::TempDir folder;
  auto driver = std::make_shared<test::FakeV4l2>(test::FakeV4l2::Time::Real);
  V4l2Options options;
  options.assemble.rate_hz = 100.0;
  options.feed.roots = {folder.path() / "dev", folder.path() / "sys"};
  for (int n = 0; n < 2; ++n) {
    CameraRequest camera;
    camera.name = "cam" + std::to_string(n + 1);
    camera.device = folder.write("video" + std::to_string(n), "").string();
    camera.format = {PixelKind::Mjpeg, {64, 48}, 100.0};
    camera.pulse_rate_hz = 100.0;
    options.cameras.push_back(camera);
    give_jpegs(driver->add(camera.device));
  }
  V4l2Source source(options, driver);
  FramePool pool({{64, 48}, {64, 48}}, 4 + source.frames_ahead());
  // What a person is told about a camera is a text, and a busy computer can make a camera look silent for a
  // while. What allocates per frame does so in every stretch.
  std::size_t least = std::numeric_limits<std::size_t>::max();
  {
    FrameSet set;
    const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(40);
    const auto read = [&](int sets) {
      while (sets > 0 && std::chrono::steady_clock::now() < until) {
        if (source.read(pool, set) == ReadStatus::Ok) --sets;
      }
    };
    read(100);
    while (least > 0 && std::chrono::steady_clock::now() < until) {
      const std::size_t before = testing::allocations();
      read(100);
      least = std::min(least, testing::allocations() - before);
    }
  }
  source.let_go();
  EXPECT_EQ(least, 0u) << "in 100 frame sets";
}

}  // namespace
}  // namespace glint
