// SPDX-License-Identifier: MIT
// Network cameras, against servers on loopback.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>

#include "host/capture/image_source.hpp"
#include "host/capture/video_decoder.hpp"
#include "tests/unit/capture/av_fixture.hpp"
#include "tests/unit/capture/mjpeg_server.hpp"

namespace glint {
namespace {

using namespace std::chrono_literals;
using test::error_of;
using test::MjpegServer;
using ::testing::AnyOf;
using ::testing::HasSubstr;
using ::testing::Not;

std::vector<std::string> jpegs(FrameSize size, std::vector<unsigned> levels) {
  std::vector<std::string> all;
  for (const unsigned level : levels) {
    all.push_back(
        test::encode_image("mjpeg", "yuvj420p", test::smooth(size.width_px, size.height_px, level)));
  }
  return all;
}

TEST(NetworkSource, TwoCamerasGiveFramesOfTheirOwn) {
  const MjpegServer first(jpegs({64, 48}, {20}), {}), second(jpegs({80, 40}, {200}), {});
  ImageSourceOptions options;
  options.camera_names = {"north", "south"};
  options.camera_sizes = {{64, 48}, {80, 40}};
  const auto source = open_image_source(first.address() + "," + second.address(), options);
  EXPECT_TRUE(source->live());
  EXPECT_EQ(source->cameras()[0].name, "north");
  EXPECT_EQ(source->cameras()[1].size.width_px, 80U);
  FramePool pool(test::sizes_of(*source), 2);
  FrameSet set;
  Timestamp last{};
  unsigned whole_sets = 0;
  for (std::uint64_t n = 0; n < 40; ++n) {
    ASSERT_EQ(source->read(pool, set), ReadStatus::Ok);
    EXPECT_EQ(number(set.trigger), n);
    EXPECT_GT(set.exposed, last);
    EXPECT_LE(set.exposed, set.delivered);
    last = set.exposed;
    if (set.frames[0]) {
      EXPECT_NEAR(set.frames[0]->image().pixels[0], 20, 4);
      EXPECT_EQ(set.frames[0]->stamp, StampPoint::HostArrival);
    }
    if (set.frames[1]) {
      EXPECT_NEAR(set.frames[1]->image().pixels[0], 200, 4);
    }
    if (set.frames[0] && set.frames[1]) ++whole_sets;
  }
  EXPECT_GE(whole_sets, 10U);
  EXPECT_EQ(source->counters().damaged, 0U);
  EXPECT_EQ(source->problem(), "");
}

TEST(NetworkSource, TheNewestImageWinsAndTheOthersAreCounted) {
  const MjpegServer server(jpegs({160, 120}, {50}), {.period = 5ms});
  const auto source = open_image_source(server.address(), {});
  FramePool pool(test::sizes_of(*source), 2);
  FrameSet set;
  ASSERT_EQ(source->read(pool, set), ReadStatus::Ok);
  const std::uint32_t before = set.frames[0]->sequence;
  // Not read for a while: everything in between is gone when the next set comes.
  std::uint32_t skipped = 0;
  while (skipped < 5) {
    std::this_thread::sleep_for(50ms);
    ASSERT_EQ(source->read(pool, set), ReadStatus::Ok);
    skipped = set.frames[0]->sequence - before - 1;
  }
  EXPECT_GE(source->counters().late, 5U);
}

TEST(NetworkSource, ACameraThatStopsDoesNotStopTheOthers) {
  const MjpegServer steady(jpegs({160, 120}, {50}), {}), stops(jpegs({160, 120}, {90}), {.frames = 5});
  ImageSourceOptions options;
  options.silence_s = 0.2;
  const auto source = open_image_source("a=" + steady.address() + ",b=" + stops.address(), options);
  FramePool pool(test::sizes_of(*source), 2);
  FrameSet set;
  for (int n = 0; n < 60; ++n) {
    ASSERT_EQ(source->read(pool, set), ReadStatus::Ok);
    EXPECT_TRUE(set.frames[0]);
  }
  EXPECT_FALSE(set.frames[1]);
  EXPECT_GE(source->counters().missing, 20U);
  EXPECT_THAT(source->problem(), HasSubstr("camera b: no data for 0."));
}

TEST(NetworkSource, EndsWhenAllHaveHungUp) {
  const MjpegServer first(jpegs({160, 120}, {50}), {.frames = 8, .hang_up = true});
  const MjpegServer second(jpegs({160, 120}, {50}), {.frames = 12, .hang_up = true});
  const auto source = open_image_source("a=" + first.address() + ",b=" + second.address(), {});
  ReadStatus last{};
  const auto sets = test::read_all(*source, last, 200);
  EXPECT_EQ(last, ReadStatus::End);
  EXPECT_GE(sets.size(), 1U);
  EXPECT_THAT(source->problem(), HasSubstr("hung up"));
}

TEST(NetworkSource, AllSilentGivesEmptySetsSoThatTheCallerCanStop) {
  const MjpegServer server(jpegs({640, 480}, {50}), {.frames = 3});
  ImageSourceOptions options;
  options.silence_s = 0.1;
  const auto source = open_image_source(server.address(), options);
  FramePool pool(test::sizes_of(*source), 2);
  FrameSet set;
  bool empty = false;
  for (int n = 0; n < 6 && !empty; ++n) {
    ASSERT_EQ(source->read(pool, set), ReadStatus::Ok);
    empty = !set.frames[0];
  }
  EXPECT_TRUE(empty);
  EXPECT_GE(source->counters().missing, 1U);
}

TEST(NetworkSource, ABrokenPictureIsDamagedAndTheNextOneIsGood) {
  std::vector<std::string> pictures = jpegs({64, 64}, {50, 50, 50});
  pictures[1].replace(pictures[1].size() / 2, 200, 200, '\x5a');
  pictures[1].resize(pictures[0].size() / 2);
  const MjpegServer server(std::move(pictures), {});
  const auto source = open_image_source(server.address(), {});
  FramePool pool(test::sizes_of(*source), 2);
  FrameSet set;
  for (int n = 0; n < 100 && (source->counters().damaged < 3 || source->counters().frames < 10); ++n) {
    ASSERT_EQ(source->read(pool, set), ReadStatus::Ok);
  }
  EXPECT_GE(source->counters().damaged, 3U);
  EXPECT_GE(source->counters().frames, 10U);
}

TEST(NetworkSource, ASilentServerIsGivenUpWithAdvice) {
  const MjpegServer good(jpegs({160, 120}, {50}), {}), silent({}, {.silent = true});
  ImageSourceOptions options;
  options.open_timeout_s = 0.3;
  const std::string text =
      error_of([&] { open_image_source("a=" + good.address() + ",b=" + silent.address(), options); });
  EXPECT_THAT(text, HasSubstr("camera b: http://127.0.0.1:"));
  EXPECT_THAT(text, HasSubstr("no image within 0.3 s; check the address"));
  EXPECT_THAT(text, Not(HasSubstr("camera a")));
  EXPECT_THAT(text, Not(HasSubstr("secret")));
}

TEST(NetworkSource, NobodyThereIsSaidAtOnce) {
  const std::string text = error_of([] { open_image_source("http://user:secret@127.0.0.1:1/stream", {}); });
  EXPECT_THAT(text,
              HasSubstr("camera cam1: http://127.0.0.1:1/stream: cannot be opened: Connection refused"));
  EXPECT_THAT(text, Not(HasSubstr("secret")));
}

TEST(NetworkSource, ASizeThatIsNotTheRigsIsRefused) {
  const MjpegServer server(jpegs({64, 48}, {20}), {});
  ImageSourceOptions options;
  options.camera_names = {"a"};
  options.camera_sizes = {{1280, 800}};
  const std::string text = error_of([&] { open_image_source(server.address(), options); });
  EXPECT_THAT(text, HasSubstr("is 64x48, but the rig says 1280x800"));
  EXPECT_THAT(text, Not(HasSubstr("secret")));
}

TEST(Address, PasswordsAreLeftOut) {
  EXPECT_EQ(without_password("rtsp://u:p@cam/live?x=a@b"), "rtsp://cam/live?x=a@b");
  EXPECT_EQ(without_password("rtsp://u:p@w@cam:554"), "rtsp://cam:554");
  EXPECT_EQ(without_password("http://cam/a@b"), "http://cam/a@b");
  EXPECT_EQ(without_password("/rec/a@b.mp4"), "/rec/a@b.mp4");
}

}  // namespace
}  // namespace glint
