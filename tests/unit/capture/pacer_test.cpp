// SPDX-License-Identifier: MIT
// When sets are due. No test here says how long anything takes, only what may not be too early.
#include "host/capture/pacer.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>

#include "host/base/error.hpp"

namespace glint {
namespace {

using namespace std::chrono_literals;

constexpr Timestamp kStart{1000s};

Timestamp recorded(std::chrono::milliseconds at) { return Timestamp(at); }

TEST(Pacer, AsRecordedKeepsTheDistancesOfTheExposures) {
  Pacer pacer({Pace::AsRecorded, 0.0});
  EXPECT_EQ(pacer.due(TriggerNo{5}, recorded(70ms), kStart), kStart);
  EXPECT_EQ(pacer.due(TriggerNo{6}, recorded(80ms), kStart + 3s), kStart + 10ms);
  EXPECT_EQ(pacer.due(TriggerNo{7}, recorded(170ms), kStart + 9s), kStart + 100ms);
}

TEST(Pacer, AtARateCountsTriggersSoThatGapsTakeTheirTime) {
  Pacer pacer({Pace::Rate, 100.0});
  EXPECT_EQ(pacer.due(TriggerNo{5}, recorded(0ms), kStart), kStart);
  EXPECT_EQ(pacer.due(TriggerNo{6}, recorded(0ms), kStart), kStart + 10ms);
  EXPECT_EQ(pacer.due(TriggerNo{16}, recorded(0ms), kStart), kStart + 110ms);
}

TEST(Pacer, DoesNotDrift) {
  Pacer pacer({Pace::Rate, 90.0});
  Timestamp last = kStart;
  for (std::uint64_t n = 0; n <= 90U * 3600U; n += 90) last = pacer.due(TriggerNo{n}, {}, kStart);
  EXPECT_EQ(last, kStart + 3600s);
}

TEST(Pacer, FastestIsAlwaysDueNow) {
  Pacer pacer({Pace::Fastest, 0.0});
  EXPECT_EQ(pacer.due(TriggerNo{0}, recorded(0ms), kStart), kStart);
  EXPECT_EQ(pacer.due(TriggerNo{1}, recorded(500ms), kStart + 1ms), kStart + 1ms);
}

TEST(Pacer, StrayStampsNeitherOverflowNorGoBeforeTheStart) {
  Pacer pacer({Pace::AsRecorded, 0.0});
  EXPECT_EQ(pacer.due(TriggerNo{0}, Timestamp(10s), kStart), kStart);
  EXPECT_EQ(pacer.due(TriggerNo{1}, Timestamp(9s), kStart), kStart);
  EXPECT_GT(pacer.due(TriggerNo{2},
                      Timestamp(std::chrono::nanoseconds(std::numeric_limits<std::int64_t>::max())), kStart),
            kStart + std::chrono::hours(24));
  Pacer rated({Pace::Rate, 1e-3});
  EXPECT_EQ(rated.due(TriggerNo{7}, {}, kStart), kStart);
  EXPECT_EQ(rated.due(TriggerNo{6}, {}, kStart), kStart);
  EXPECT_GT(rated.due(TriggerNo{std::numeric_limits<std::uint64_t>::max()}, {}, kStart), kStart);
}

TEST(Pacer, RateNeedsARate) {
  EXPECT_THROW(Pacer({Pace::Rate, 0.0}), Error);
  EXPECT_THROW(Pacer({Pace::Rate, -1.0}), Error);
  EXPECT_THROW(Pacer({Pace::Rate, std::numeric_limits<double>::quiet_NaN()}), Error);
}

TEST(Pacer, WaitIsNeverTooShort) {
  Pacer pacer({Pace::Fastest, 0.0});
  for (const auto pause : {1ms, 7ms, 120ms}) {
    const Timestamp due = std::chrono::steady_clock::now() + pause;
    EXPECT_EQ(pacer.wait(due), 0.0);
    EXPECT_GE(std::chrono::steady_clock::now(), due);
  }
  EXPECT_EQ(pacer.lateness().sets, 3U);
  EXPECT_EQ(pacer.lateness().late, 0U);
}

TEST(Pacer, LateSetsAreCounted) {
  Pacer pacer({Pace::Fastest, 0.0});
  EXPECT_GE(pacer.wait(std::chrono::steady_clock::now() - 2s), 2.0);
  EXPECT_EQ(pacer.lateness().late, 1U);
  EXPECT_GE(pacer.lateness().max_s, 2.0);
}

TEST(Pacer, AStopEndsTheWait) {
  Pacer pacer({Pace::Fastest, 0.0});
  std::stop_source source;
  std::jthread stopper([&] { source.request_stop(); });
  pacer.wait(std::chrono::steady_clock::now() + std::chrono::hours(1), source.get_token());
}

}  // namespace
}  // namespace glint
