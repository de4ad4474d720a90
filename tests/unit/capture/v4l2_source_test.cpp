// SPDX-License-Identifier: MIT
// Several cameras as one source: faults of one are no fault of the others.
#include "host/capture/v4l2/v4l2_source.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <mutex>
#include <thread>

#include "tests/unit/capture/camera_stream_fixture.hpp"
#include "tests/unit/capture/fake_sysfs.hpp"

namespace glint {
namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;
using test::error_of;
using test::FakeCamera;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

constexpr double kRate_hz = 50.0;

/// Three USB cameras on a common trigger, in real time.
class Source : public ::testing::Test {
 protected:
  Source() {
    for (unsigned n = 0; n < 3; ++n) {
      const std::string port = "1-" + std::to_string(n + 1);
      tree_.add_usb(2 * n, port, "");
      FakeCamera& camera = driver_->add(tree_.node(2 * n));
      camera.rate_hz = kRate_hz;
      camera.formats[0].sizes[0].rates_hz = {kRate_hz};
      CameraRequest request;
      request.name = names_[n];
      request.device = "usb:" + port;
      request.format = {PixelKind::Grey, {64, 48}, kRate_hz};
      request.pulse_rate_hz = kRate_hz;
      options_.cameras.push_back(request);
    }
    options_.assemble.rate_hz = kRate_hz;
    options_.feed.roots = tree_.roots();
    options_.feed.retry = milliseconds(50);
    options_.feed.on_event = [this](const std::string& text) {
      const std::lock_guard lock(mutex_);
      events_.push_back(text);
    };
  }
  void open() {
    source_ = std::make_unique<V4l2Source>(options_, driver_);
    std::vector<FrameSize> sizes;
    for (const SourceCamera& camera : source_->cameras()) sizes.push_back(camera.size);
    pool_ = std::make_unique<FramePool>(sizes, 4 + source_->frames_ahead());
  }
  ~Source() override {
    if (source_) source_->let_go();
  }
  /// Reads for so long, or until `enough`; counts frames of each camera.
  template <typename Enough>
  void read_until(milliseconds longest, const Enough& enough) {
    const auto until = steady_clock::now() + longest;
    while (steady_clock::now() < until && !enough()) {
      const ReadStatus status = source_->read(*pool_, set_);
      if (status == ReadStatus::Idle) ++idles_;
      if (status != ReadStatus::Ok) continue;
      EXPECT_TRUE(sets_ == 0 || number(set_.trigger) > last_);
      ++sets_;
      last_ = number(set_.trigger);
      for (std::size_t n = 0; n < frames_.size(); ++n) {
        if (set_.frames[n] && !set_.frames[n]->damaged) ++frames_[n];
      }
    }
  }
  void read_for(milliseconds time) {
    read_until(time, [] { return false; });
  }
  void forget() { frames_ = {}, sets_ = 0, idles_ = 0; }
  std::vector<std::string> events() {
    const std::lock_guard lock(mutex_);
    return events_;
  }
  bool told(const std::string& part) {
    const auto all = events();
    return std::any_of(all.begin(), all.end(),
                       [&](const std::string& event) { return event.find(part) != std::string::npos; });
  }
  void expect_balance() {
    const Ledger* const ledger = source_->ledger();
    ASSERT_NE(ledger, nullptr);
    for (const CameraLedger& camera : ledger->cameras) EXPECT_EQ(camera.total(), ledger->pulses);
  }

  const std::array<std::string, 3> names_{"left", "middle", "right"};
  test::FakeSysfs tree_;
  std::shared_ptr<test::FakeV4l2> driver_ = std::make_shared<test::FakeV4l2>(test::FakeV4l2::Time::Real);
  V4l2Options options_;
  std::mutex mutex_;
  std::vector<std::string> events_;
  std::unique_ptr<FramePool> pool_;
  std::unique_ptr<V4l2Source> source_;
  FrameSet set_;
  std::array<std::uint64_t, 3> frames_{};
  std::uint64_t sets_ = 0, idles_ = 0, last_ = 0;
};

TEST_F(Source, GivesWholeSets) {
  open();
  EXPECT_TRUE(source_->live());
  ASSERT_EQ(source_->cameras().size(), 3u);
  EXPECT_EQ(source_->cameras()[1].name, "middle");
  read_for(milliseconds(600));
  forget();
  read_for(milliseconds(1000));
  EXPECT_GE(sets_, 40u);
  for (const std::uint64_t frames : frames_) EXPECT_GE(frames + 5, sets_);
  expect_balance();
  EXPECT_EQ(source_->problem(), "");
  EXPECT_THAT(events(), ::testing::IsEmpty());
}

TEST_F(Source, AShiftIsAskedForFromAnotherThreadAndMarkedOnTheFrames) {
  open();
  std::int64_t before = 0, after = 0;
  const auto pair = [&](int shifted) {
    return set_.frames[0] && set_.frames[1] && set_.frames[1]->shifted == shifted;
  };
  const auto ahead = [&] { return std::int64_t{set_.frames[1]->sequence} - set_.frames[0]->sequence; };
  read_for(milliseconds(800));
  read_until(milliseconds(1000), [&] { return pair(0); });
  ASSERT_TRUE(pair(0));
  before = ahead();
  const std::uint32_t run = set_.frames[1]->run;
  std::thread([this] { source_->shift(CameraId{1}, -2); }).join();
  read_until(milliseconds(1000), [&] { return pair(-2); });
  ASSERT_TRUE(pair(-2));
  after = ahead();
  EXPECT_EQ(after, before + 2) << "frames two pulses younger";
  EXPECT_NE(set_.frames[1]->run, run);
  EXPECT_EQ(set_.frames[0]->shifted, 0);
  source_->shift(CameraId{1}, 0);
  read_until(milliseconds(1000), [&] { return pair(0); });
  ASSERT_TRUE(pair(0));
  EXPECT_EQ(ahead(), before);
  expect_balance();
}

TEST_F(Source, AnUnpluggedCameraIsToldOfAtOnceAndTakenBackUnderAnotherNumber) {
  open();
  read_for(milliseconds(600));
  forget();
  const auto pulled = steady_clock::now();
  driver_->with(tree_.node(2), [](FakeCamera& camera) { camera.plugged = false; });
  tree_.remove(2);
  read_until(milliseconds(2000), [&] { return told("unplugged"); });
  EXPECT_LT(steady_clock::now() - pulled, milliseconds(300));
  EXPECT_THAT(events(), Contains(HasSubstr("camera middle was unplugged")));
  forget();
  read_for(milliseconds(600));
  EXPECT_EQ(frames_[1], 0u);
  EXPECT_GE(frames_[0], 20u);
  EXPECT_GE(frames_[2] + 3, frames_[0]);

  tree_.add_usb(8, "1-2", "");
  FakeCamera& again = driver_->add(tree_.node(8));
  driver_->with(tree_.node(8), [&](FakeCamera& camera) {
    camera.rate_hz = kRate_hz;
    camera.formats[0].sizes[0].rates_hz = {kRate_hz};
  });
  read_until(milliseconds(3000), [&] { return told("is back"); });
  EXPECT_THAT(events(), Contains(AllOf(HasSubstr("camera middle is back"), HasSubstr("video8"))));
  forget();
  read_for(milliseconds(600));
  EXPECT_GE(frames_[1], 20u);
  EXPECT_GE(driver_->with(tree_.node(8), [](FakeCamera& camera) { return camera.opened; }), 1u);
  (void)again;
  expect_balance();
  EXPECT_THAT(source_->problem(), HasSubstr("camera middle: unplugged 1 time"));
}

TEST_F(Source, ADriverThatFailsIsOpenedAgain) {
  open();
  read_for(milliseconds(600));
  driver_->with(tree_.node(0), [](FakeCamera& camera) { camera.answers[VIDIOC_DQBUF] = {EIO}; });
  read_until(milliseconds(2000), [&] { return told("camera left is back"); });
  EXPECT_TRUE(told("camera left failed: the driver failed: Input/output error"));
  EXPECT_TRUE(told("camera left is back"));
  forget();
  read_until(milliseconds(3000), [&] { return frames_[0] >= 12; });
  EXPECT_GE(frames_[0], 12u);
}

TEST_F(Source, SilenceIsToldOnceAndSoIsItsEnd) {
  open();
  read_for(milliseconds(600));
  driver_->with(tree_.node(4), [](FakeCamera& camera) { camera.hung = true; });
  read_until(milliseconds(1500), [&] { return told("camera right gives no frames"); });
  forget();
  read_for(milliseconds(500));
  EXPECT_EQ(frames_[2], 0u);
  EXPECT_GE(frames_[0], 15u) << "the others go on";
  driver_->with(tree_.node(4), [](FakeCamera& camera) { camera.hung = false; });
  read_until(milliseconds(1500), [&] { return told("camera right is back"); });
  int silences = 0;
  for (const std::string& event : events()) silences += event.find("gives no frames") != std::string::npos;
  EXPECT_EQ(silences, 1);
  EXPECT_TRUE(told("camera right is back"));
  expect_balance();
}

TEST_F(Source, WithoutAnyFrameTheReaderIsLetGoNowAndThen) {
  for (unsigned n = 0; n < 3; ++n)
    driver_->with(tree_.node(2 * n), [](FakeCamera& camera) { camera.hung = true; });
  open();
  read_for(milliseconds(1000));
  EXPECT_EQ(sets_, 0u);
  EXPECT_GE(idles_, 3u);
  EXPECT_LE(idles_, 6u);
}

TEST_F(Source, DamagedFramesAreInTheLedger) {
  driver_->with(tree_.node(0), [](FakeCamera& camera) {
    camera.frame = [](std::uint64_t pulse, test::FakeFrame& frame) {
      frame.bytes.assign(64 * 48, 1);
      if (pulse % 4 == 0) frame.flags |= V4L2_BUF_FLAG_ERROR;
      return true;
    };
  });
  open();
  read_for(milliseconds(1500));
  const SourceCounters counters = source_->counters();
  EXPECT_GE(counters.damaged, 10u);
  EXPECT_LE(counters.damaged, 20u);
  EXPECT_THAT(source_->problem(), HasSubstr("frames flagged by the driver"));
  expect_balance();
}

TEST_F(Source, AnotherPoolCanBeReadInto) {
  open();
  read_for(milliseconds(500));
  for (auto& frame : set_.frames) frame.reset();
  source_->let_go();
  pool_ = std::make_unique<FramePool>(std::vector<FrameSize>(3, {64, 48}), 4 + source_->frames_ahead());
  forget();
  read_for(milliseconds(1000));
  EXPECT_GE(frames_[0], 25u);
  expect_balance();
}

TEST_F(Source, ACameraUnpluggedBetweenTwoPoolsIsTakenBackToo) {
  open();
  read_for(milliseconds(300));
  source_->let_go();
  driver_->with(tree_.node(2), [](FakeCamera& camera) { camera.plugged = false; });
  forget();
  read_until(milliseconds(5000), [&] { return frames_[0] >= 10; });
  EXPECT_GE(frames_[0], 10u);
  EXPECT_EQ(frames_[1], 0u);
  EXPECT_TRUE(told("camera middle was unplugged"));
  driver_->with(tree_.node(2), [](FakeCamera& camera) { camera.plugged = true; });
  read_until(milliseconds(5000), [&] { return frames_[1] >= 5; });
  EXPECT_GE(frames_[1], 5u);
  EXPECT_TRUE(told("camera middle is back"));
  expect_balance();
}

TEST_F(Source, EveryCameraThatCannotBeOpenedIsNamed) {
  options_.cameras[0].device = "usb:7-7";
  options_.cameras[2].format.rate_hz = 75.0;
  const std::string problems = error_of([&] { open(); });
  EXPECT_THAT(problems, HasSubstr("camera left: \"usb:7-7\" is not there"));
  EXPECT_THAT(problems,
              HasSubstr("camera right (" + tree_.node(4) + "): does not offer grey 64x48 at 75 Hz"));
  EXPECT_EQ(driver_->open_nodes(), 0);
}

TEST_F(Source, WithoutARateTheCamerasTellIt) {
  for (CameraRequest& camera : options_.cameras) camera.format.rate_hz = camera.pulse_rate_hz = 0.0;
  options_.assemble.rate_hz = 0.0;
  for (unsigned n = 0; n < 3; ++n)
    driver_->with(tree_.node(2 * n), [](FakeCamera& camera) { camera.set_rate_hz = kRate_hz; });
  open();
  EXPECT_EQ(source_->rate_hz(), kRate_hz);
  read_for(milliseconds(1200));
  EXPECT_GE(frames_[0], 10u);
}

TEST_F(Source, AStartThatFailsIsReportedByReading) {
  open();
  driver_->with(tree_.node(2), [](FakeCamera& camera) { camera.answers[VIDIOC_STREAMON] = {ENOSPC}; });
  EXPECT_EQ(source_->read(*pool_, set_), ReadStatus::Failed);
  EXPECT_THAT(source_->problem(), HasSubstr("camera middle"));
  EXPECT_THAT(source_->problem(), HasSubstr("no bandwidth left"));
  EXPECT_EQ(source_->read(*pool_, set_), ReadStatus::Failed);
}

TEST_F(Source, ASlowReaderLosesFramesButNothingElse) {
  open();
  read_for(milliseconds(500));
  std::this_thread::sleep_for(milliseconds(800));
  forget();
  read_for(milliseconds(500));
  EXPECT_GE(frames_[0], 15u);
  expect_balance();
}

}  // namespace
}  // namespace glint
