// SPDX-License-Identifier: MIT
// A run's board: the firmware's own logic at the other end, in real time.
#include "host/sync/board_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <mutex>
#include <thread>
#include <vector>

#include "host/base/pulse_code.hpp"
#include "tests/unit/usb-sync/plugged_board.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::HasSubstr;

/// What the board's thread said.
class Said {
 public:
  void add(const std::string& text) {
    const std::lock_guard lock(mutex_);
    texts_.push_back(text);
  }
  std::vector<std::string> texts() const {
    const std::lock_guard lock(mutex_);
    return texts_;
  }

 private:
  mutable std::mutex mutex_;
  std::vector<std::string> texts_;
};

BoardRunOptions options_for(Said& said) {
  BoardRunOptions options;
  options.link.clock.least_request = options.link.clock.least_answer =
      sync::Seconds(0.0);  // there is no wire
  options.plan.period = sync::Seconds(0.005);
  options.plan.outputs[0] = {.enabled = true, .width = sync::Seconds(100e-6)};
  options.plan.outputs[4] = {.enabled = true, .delay = sync::Seconds(788e-6), .width = sync::Seconds(50e-6)};
  options.on_event = [&said](const std::string& text) { said.add(text); };
  return options;
}

std::vector<FiredPulse> take_for(BoardRun& run, std::chrono::milliseconds time) {
  std::this_thread::sleep_for(time);
  std::vector<FiredPulse> pulses;
  for (FiredPulse pulse; run.take(pulse);) pulses.push_back(pulse);
  return pulses;
}

/// Those from the last pulse 0 on.
std::vector<FiredPulse> newest_run(std::vector<FiredPulse> pulses) {
  const auto first = std::find_if(pulses.rbegin(), pulses.rend(),
                                  [](const FiredPulse& pulse) { return number(pulse.trigger) == 0; });
  if (first != pulses.rend()) pulses.erase(pulses.begin(), std::prev(first.base()));
  return pulses;
}

void expect_whole(const std::vector<FiredPulse>& pulses, double period_s) {
  for (std::size_t i = 0; i < pulses.size(); ++i) {
    ASSERT_EQ(number(pulses[i].trigger), i);
    if (i == 0) continue;
    const double step_s = seconds_between(pulses[i - 1].exposed, pulses[i].exposed);
    EXPECT_NEAR(step_s, period_s, pulses[i].error_s + pulses[i - 1].error_s + 1e-9);
  }
}

TEST(BoardRun, StartsTheBoardTellsOfEveryPulseAndStopsIt) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRun run(options_for(said), bus);
  EXPECT_TRUE(take_for(run, 50ms).empty()) << "not before cameras wait";
  const Timestamp before = std::chrono::steady_clock::now();
  run.begin();
  const std::vector<FiredPulse> pulses = take_for(run, 400ms);
  const Timestamp after = std::chrono::steady_clock::now();
  run.end();
  ASSERT_GT(pulses.size(), 30u);
  expect_whole(pulses, 0.005);
  EXPECT_GT(pulses.front().exposed, before);
  EXPECT_LT(pulses.back().exposed, after);
  EXPECT_TRUE(pulses.back().lights_on);
  EXPECT_GT(pulses.back().error_s, 0.0);
  EXPECT_EQ(run.counters().not_told, 0u);
  std::this_thread::sleep_for(50ms);
  EXPECT_EQ(sync::SyncBoard::open("", bus).status().state, sync::RunState::Idle);
}

TEST(BoardRun, EachBeginningCountsFromZero) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRun run(options_for(said), bus);
  for (int i = 0; i < 3; ++i) {
    run.begin();
    const std::vector<FiredPulse> pulses = take_for(run, 150ms);
    ASSERT_GT(pulses.size(), 5u);
    expect_whole(pulses, 0.005);
  }
}

TEST(BoardRun, DarkPulsesAreThoseOfTheCode) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRunOptions options = options_for(said);
  options.plan.code = {.seed = 7, .group = 18};
  BoardRun run(options, bus);
  run.begin();
  const std::vector<FiredPulse> pulses = take_for(run, 400ms);
  const PulseCode code(7, 18);
  ASSERT_GT(pulses.size(), 40u);
  for (const FiredPulse& pulse : pulses) EXPECT_EQ(pulse.lights_on, !code.dark(number(pulse.trigger)));
}

TEST(BoardRun, ABoardThatWasResetIsStartedAgain) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRun run(options_for(said), bus);
  run.begin();
  EXPECT_FALSE(take_for(run, 150ms).empty());
  board.reset();
  const std::vector<FiredPulse> pulses = newest_run(take_for(run, 800ms));
  run.end();
  EXPECT_EQ(run.counters().resets, 1u);
  EXPECT_THAT(said.texts(), Contains(HasSubstr("started again")));
  ASSERT_GT(pulses.size(), 10u);
  expect_whole(pulses, 0.005);
}

TEST(BoardRun, ABoardThatGaveItsHostUpIsStartedAgain) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRunOptions options = options_for(said);
  options.plan.keepalive = 2000ms;
  BoardRun run(options, bus);
  run.begin();
  EXPECT_FALSE(take_for(run, 150ms).empty());
  board.reset_bus();
  const std::vector<FiredPulse> pulses = newest_run(take_for(run, 600ms));
  EXPECT_EQ(run.counters().resets, 0u);
  EXPECT_THAT(said.texts(), Contains(HasSubstr("its host was gone")));
  EXPECT_THAT(said.texts(), Contains(HasSubstr("started again")));
  ASSERT_GT(pulses.size(), 10u);
  expect_whole(pulses, 0.005);
}

TEST(BoardRun, LightsThatAreHeldOffAreTold) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRun run(options_for(said), bus);
  run.begin();
  EXPECT_FALSE(take_for(run, 150ms).empty());
  board.supply_mv = 14'500;
  const std::vector<FiredPulse> pulses = take_for(run, 200ms);
  ASSERT_FALSE(pulses.empty());
  EXPECT_FALSE(pulses.back().lights_on);
  EXPECT_EQ(run.counters().lockouts, 1u);
  EXPECT_THAT(said.texts(), Contains(HasSubstr("14.5 V")));
}

TEST(BoardRun, APlanThatIsRefusedSaysWhy) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRunOptions options = options_for(said);
  options.plan.outputs[4].width = sync::Seconds(400e-6);
  BoardRun run(options, bus);
  EXPECT_THROW(run.begin(), sync::Refused);
  EXPECT_TRUE(take_for(run, 20ms).empty());
}

TEST(BoardRun, ABoardThatIsFollowedIsLeftAlone) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Said said;
  BoardRunOptions options = options_for(said);
  auto owner = sync::SyncBoard::open("", bus);
  owner.start(options.plan);
  options.follow = true;
  {
    BoardRun run(options, bus);
    run.begin();
    EXPECT_GT(take_for(run, 200ms).size(), 10u);
  }
  EXPECT_EQ(owner.status().state, sync::RunState::Running);
  owner.stop();
}

TEST(BoardRun, WithoutABoardThereIsNoRun) {
  sync::PluggedBus bus({});
  Said said;
  EXPECT_THROW(BoardRun(options_for(said), bus), sync::NoBoard);
}

}  // namespace
}  // namespace glint
