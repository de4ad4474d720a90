// SPDX-License-Identifier: MIT
// Live cameras into the detector: learning and tracking take turns with the cameras, and losses are told.
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <memory>
#include <thread>

#include "host/assemble/ledger.hpp"
#include "host/base/error.hpp"
#include "host/capture/v4l2/v4l2_source.hpp"
#include "host/pipeline/frame_input.hpp"
#include "host/pipeline/learn_background.hpp"
#include "tests/support/temp_dir.hpp"
#include "tests/unit/capture/fake_v4l2.hpp"

namespace glint {
namespace {

constexpr std::uint32_t kWidth = 128, kHeight = 64;
constexpr double kRate_hz = 100.0;

class LiveCameras : public ::testing::Test {
 protected:
  LiveCameras() {
    options_.feed.on_thread = [this] { ++camera_threads_; };
    options_.assemble.rate_hz = kRate_hz;
    options_.feed.roots = {folder_.path() / "dev", folder_.path() / "sys"};
    options_.feed.retry = std::chrono::milliseconds(50);
    for (int n = 0; n < 2; ++n) {
      CameraRequest camera;
      camera.name = "cam" + std::to_string(n + 1);
      camera.device = folder_.write("video" + std::to_string(n), "").string();
      camera.format = {PixelKind::Grey, {kWidth, kHeight}, kRate_hz};
      camera.pulse_rate_hz = kRate_hz;
      options_.cameras.push_back(camera);
      test::FakeCamera& fake = driver_->add(camera.device);
      fake.formats = {{V4L2_PIX_FMT_GREY, {{kWidth, kHeight, {kRate_hz}}}}};
      fake.takes_pointers = n == 0;
      fake.frame = [this](std::uint64_t, test::FakeFrame& frame) {
        frame.bytes.assign(kWidth * kHeight, 10);
        // The marker is switched on after the background was learnt.
        for (std::size_t y = 30; lit_ && y < 34; ++y) {
          for (std::size_t x = 60; x < 66; ++x) frame.bytes[y * kWidth + x] = 200;
        }
        return true;
      };
    }
  }
  test::TempDir folder_;
  std::shared_ptr<test::FakeV4l2> driver_ = std::make_shared<test::FakeV4l2>(test::FakeV4l2::Time::Real);
  V4l2Options options_;
  std::atomic<bool> lit_{false};
  std::atomic<int> camera_threads_{0}, capture_threads_{0};
};

TEST_F(LiveCameras, AreLearntFromAndThenDetectedOn) {
  auto source = std::make_unique<V4l2Source>(options_, driver_);
  const LearntBackgrounds learnt = learn_backgrounds(*source, 10, 12);
  EXPECT_GE(learnt.frames, 8u) << "of ten sets; a busy computer may miss one";
  lit_ = true;
  FrameInputOptions input_options;
  input_options.device = "cpu";
  input_options.pace = {Pace::Fastest, 0.0};
  input_options.max_sets = 60;
  input_options.on_capture_thread = [this] { ++capture_threads_; };
  FrameInput input(std::move(source), std::vector<gpu::Lens>(2), input_options);
  for (std::uint32_t n = 0; n < 2; ++n) input.set_background(n, learnt.cameras[n]);

  TickBlobs tick;
  std::uint64_t ticks = 0, blobs = 0;
  while (input.next(tick) == ReadStatus::Ok) {
    ++ticks;
    ASSERT_TRUE(tick.live);
    EXPECT_LT(seconds_between(tick.live->stamped, tick.detected), 1.0);
    EXPECT_GE(tick.live->arrived, tick.live->stamped);
    EXPECT_EQ(tick.live->stamp, StampPoint::StartOfExposure);
    EXPECT_GE(tick.live->exposed_error_s, 0.0);
    EXPECT_LT(tick.live->exposed_error_s, 1.0 / kRate_hz);
    for (std::uint32_t n = 0; n < 2; ++n) EXPECT_EQ((tick.frames >> n) & 1, tick.images[n].pixels != nullptr);
    for (const auto& camera : tick.cameras) {
      blobs += camera.size();
      for (const gpu::BlobRecord& blob : camera) EXPECT_EQ(blob.area_px, 24u);
    }
  }
  EXPECT_EQ(camera_threads_, 2 * 2) << "two cameras, for learning and for tracking";
  EXPECT_EQ(capture_threads_, 1);
  const InputCounters counters = input.counters();
  EXPECT_EQ(ticks + counters.dropped, 60u);
  EXPECT_GE(ticks, 40u);
  EXPECT_GE(blobs, 2 * ticks - 10);
  const Ledger* const ledger = input.ledger();
  ASSERT_NE(ledger, nullptr);
  ASSERT_EQ(ledger->cameras.size(), 2u);
  EXPECT_GE(ledger->pulses, 60u);
  for (std::size_t n = 0; n < 2; ++n) {
    const CameraLedger& camera = ledger->cameras[n];
    // Sets that the reader was behind for are known as skipped at the end only.
    EXPECT_LE(counters.not_used[n], camera.total() - camera[FrameFate::Used]);
    EXPECT_GE(counters.not_used[n] + camera[FrameFate::Skipped], camera.total() - camera[FrameFate::Used]);
  }
  for (const CameraLedger& camera : ledger->cameras) EXPECT_EQ(camera.total(), ledger->pulses);
}

TEST_F(LiveCameras, ThatNeverGiveAFrameEndTheLearning) {
  for (const CameraRequest& camera : options_.cameras)
    driver_->with(camera.device, [](test::FakeCamera& fake) { fake.hung = true; });
  V4l2Source source(options_, driver_);
  try {
    (void)learn_backgrounds(source, 10, 12);
    FAIL() << "learnt from nothing";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("are the cameras triggered?"), std::string::npos)
        << error.what();
  }
}

TEST_F(LiveCameras, AStopIsHeardWhileNothingComes) {
  auto source = std::make_unique<V4l2Source>(options_, driver_);
  for (const CameraRequest& camera : options_.cameras)
    driver_->with(camera.device, [](test::FakeCamera& fake) { fake.hung = true; });
  FrameInputOptions input_options;
  input_options.device = "cpu";
  input_options.pace = {Pace::Fastest, 0.0};
  FrameInput input(std::move(source), std::vector<gpu::Lens>(2), input_options);
  std::jthread stopper([&input] {
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    input.stop();
  });
  TickBlobs tick;
  EXPECT_EQ(input.next(tick), ReadStatus::End);
}

TEST_F(LiveCameras, AStartThatFailsFailsTheRun) {
  auto source = std::make_unique<V4l2Source>(options_, driver_);
  driver_->with(options_.cameras[1].device,
                [](test::FakeCamera& fake) { fake.answers[VIDIOC_STREAMON] = {ENOSPC}; });
  FrameInputOptions input_options;
  input_options.device = "cpu";
  input_options.pace = {Pace::Fastest, 0.0};
  FrameInput input(std::move(source), std::vector<gpu::Lens>(2), input_options);
  TickBlobs tick;
  EXPECT_EQ(input.next(tick), ReadStatus::Failed);
  EXPECT_NE(input.problem().find("camera cam2"), std::string::npos);
}

}  // namespace
}  // namespace glint
