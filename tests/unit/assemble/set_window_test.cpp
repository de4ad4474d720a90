// SPDX-License-Identifier: MIT
#include "host/assemble/set_window.hpp"

#include <gtest/gtest.h>

namespace glint {
namespace {

using enum FrameFate;

class SetWindowTest : public ::testing::Test {
 protected:
  SetWindowTest() { window.begin(10); }
  Frame frame(std::uint8_t camera, bool damaged = false) {
    Frame made = std::move(*pool.take(CameraId{camera}));
    made.damaged = damaged;
    return made;
  }
  const CameraLedger& camera(std::size_t k) const { return window.ledger().cameras[k]; }

  FramePool pool{std::vector<FrameSize>(2, FrameSize{16, 8}), 8};
  SetWindow window{2, 4};
  FrameSet set;
};

TEST_F(SetWindowTest, HandsOnWhatCame) {
  EXPECT_TRUE(window.put(10, frame(0), Timestamp{} + std::chrono::seconds(2)));
  EXPECT_TRUE(window.put(10, frame(1), Timestamp{} + std::chrono::seconds(1)));
  EXPECT_FALSE(window.put(10, frame(1), {}));
  EXPECT_TRUE(window.has_frames(10));
  EXPECT_EQ(window.ledger().pulses, 0u);
  window.retire(Used, &set);
  EXPECT_TRUE(set.frames[0] && set.frames[1]);
  EXPECT_EQ(set.delivered, Timestamp{} + std::chrono::seconds(2));
  EXPECT_EQ(camera(0)[Used], 1u);
  EXPECT_EQ(camera(1)[Used], 1u);
  EXPECT_EQ(camera(1).duplicates, 1u);
  EXPECT_FALSE(window.put(10, frame(1), {}));
  EXPECT_EQ(camera(1).duplicates, 2u);
  EXPECT_FALSE(window.put(9, frame(0), {}));
  EXPECT_EQ(camera(0).warm_up, 1u);
  EXPECT_TRUE(window.ledger().balanced());
}

TEST_F(SetWindowTest, OldestIsSkippedWhenTooManyAreOpen) {
  for (std::int64_t pulse = 10; pulse < 16; ++pulse) EXPECT_TRUE(window.put(pulse, frame(0), {}));
  EXPECT_EQ(window.head(), 12);
  EXPECT_EQ(window.newest(), 15);
  EXPECT_EQ(camera(0)[Skipped], 2u);
  EXPECT_EQ(camera(1)[LostByCamera], 2u);
  EXPECT_TRUE(window.put(10, frame(1), {}));
  EXPECT_EQ(camera(1)[Late], 1u);
  EXPECT_TRUE(window.ledger().balanced());
}

TEST_F(SetWindowTest, MissingFramesAreTheHostsIfTheDriverCountedThem) {
  EXPECT_TRUE(window.put(10, frame(0), {}));
  EXPECT_TRUE(window.put(13, frame(0), {}));
  window.retire(Used, nullptr);
  window.retire(Used, nullptr);
  window.lost_by_host(CameraId{0}, 10, 13, 2);  // one pulse retired, one open
  window.retire(Used, nullptr);
  EXPECT_EQ(camera(0)[LostByHost], 2u);
  EXPECT_EQ(camera(0)[LostByCamera], 0u);
  EXPECT_TRUE(window.put(11, frame(0), {}));  // it was only overtaken
  EXPECT_EQ(camera(0)[LostByHost], 1u);
  EXPECT_EQ(camera(0)[Late], 1u);
  EXPECT_TRUE(window.ledger().balanced());
}

TEST_F(SetWindowTest, AnOvertakenFrameTakesBackAWrongGuess) {
  EXPECT_TRUE(window.put(10, frame(0), {}));
  EXPECT_TRUE(window.put(13, frame(0), {}));
  window.lost_by_host(CameraId{0}, 10, 13, 1);  // 11 or 12; 11 is taken
  window.came_after_all(CameraId{0}, 12);
  EXPECT_TRUE(window.put(12, frame(0), {}));
  while (window.open()) window.retire(Used, nullptr);
  EXPECT_EQ(camera(0)[LostByHost], 0u);
  EXPECT_EQ(camera(0)[LostByCamera], 1u);
  EXPECT_EQ(camera(0)[Used], 3u);
}

TEST_F(SetWindowTest, DamagedIsCorruptInTimeOrNot) {
  EXPECT_TRUE(window.put(10, frame(0, true), {}));
  EXPECT_FALSE(window.has_frames(10));
  EXPECT_FALSE(window.lacks(10, CameraId{0}));
  window.retire(Used, nullptr);
  EXPECT_TRUE(window.put(10, frame(1, true), {}));
  EXPECT_EQ(camera(0)[Corrupt], 1u);
  EXPECT_EQ(camera(1)[Corrupt], 1u);
  EXPECT_TRUE(window.ledger().balanced());
}

TEST_F(SetWindowTest, ALongPauseIsCountedAtOnce) {
  EXPECT_TRUE(window.put(10, frame(0), {}));
  constexpr std::int64_t kFar = 1'000'000'000'000;
  EXPECT_TRUE(window.put(kFar, frame(0), {}));
  window.lost_by_host(CameraId{0}, 10, kFar, 1'000'000);
  while (window.open()) window.retire(Used, nullptr);
  EXPECT_EQ(window.ledger().pulses, static_cast<std::uint64_t>(kFar - 9));
  EXPECT_EQ(camera(0)[LostByHost], 1'000'000u);
  EXPECT_EQ(camera(0)[Skipped], 1u);
  EXPECT_EQ(camera(0)[Used], 1u);
  EXPECT_TRUE(window.ledger().balanced());
  EXPECT_FALSE(window.put(kFar - SetWindow::kRemembered, frame(1), {}));
  EXPECT_EQ(camera(1).unplaced, 1u);
  EXPECT_TRUE(window.put(kFar - SetWindow::kRemembered + 1, frame(1), {}));
  EXPECT_EQ(camera(1)[Late], 1u);
}

TEST_F(SetWindowTest, HeldFramesCanBeTakenOut) {
  EXPECT_TRUE(window.put(10, frame(0), {}));
  EXPECT_TRUE(window.put(10, frame(1), {}));
  window.drop_held(CameraId{1});
  window.retire(Used, &set);
  EXPECT_TRUE(set.frames[0]);
  EXPECT_FALSE(set.frames[1]);
  EXPECT_EQ(camera(1)[Skipped], 1u);
}

}  // namespace
}  // namespace glint
