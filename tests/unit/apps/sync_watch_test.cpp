// SPDX-License-Identifier: MIT
// The watch, with a board that comes and goes.
#include "host/apps/sync_watch.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "tests/unit/usb-sync/plugged_board.hpp"

namespace glint::apps {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

class NotedWatch final : public WatchSink {
 public:
  void begin(const sync::Info& board) override { info = board; }
  void event(const WatchEvent& event) override {
    kinds.push_back(event.kind);
    if (on_event) on_event(event.kind);
  }
  void update(const WatchUpdate& update) override {
    updates.push_back(update);
    if (on_update) on_update(updates.size());
  }
  void end(const WatchSummary& all) override { summary = all; }

  std::function<void(const std::string&)> on_event;
  std::function<void(std::size_t)> on_update;
  sync::Info info;
  std::vector<std::string> kinds;
  std::vector<WatchUpdate> updates;
  std::optional<WatchSummary> summary;
};

class SyncWatch : public ::testing::Test {
 protected:
  SyncWatch() {
    options_.clock.least_request = options_.clock.least_answer = 0s;  // the cable is memory
    options_.reopen_period = 5ms;
    options_.status_period = 50ms;
    watch_options_.update_period = 200ms;
    watch_options_.seconds = 10.0;  // ends a test that has gone wrong
  }
  static sync::BoardPlan plan_of(sync::Seconds period) {
    sync::BoardPlan plan;
    plan.period = period;
    plan.outputs[0] = {.enabled = true, .width = 100us};
    plan.outputs[4] = {.enabled = true, .width = 20us};
    return plan;
  }
  void run() {
    sync::BoardLink link("", options_, bus_);
    link_ = &link;
    watch(link, sink_, watch_options_, stop_);
    link_ = nullptr;
    ASSERT_TRUE(sink_.summary);
  }

  sync::PluggedBoard plugged_;
  sync::PluggedBus bus_{{&plugged_}};
  sync::LinkOptions options_;
  WatchOptions watch_options_;
  NotedWatch sink_;
  std::atomic<bool> stop_ = false;
  sync::BoardLink* link_ = nullptr;
};

TEST_F(SyncWatch, SaysRateDelaySupplyAndClock) {
  sync::SyncBoard::open("", bus_).start(plan_of(2ms));
  sink_.on_update = [this](std::size_t count) { stop_ = count == 3; };
  run();
  EXPECT_EQ(sink_.info.serial, plugged_.serial_text());
  const WatchUpdate& update = sink_.updates.back();
  EXPECT_TRUE(update.present);
  EXPECT_EQ(update.state, sync::RunState::Running);
  ASSERT_TRUE(update.window.rate_hz);
  EXPECT_NEAR(*update.window.rate_hz, 500.0, 1e-6);
  EXPECT_GT(update.window.delay.count, 10u);
  EXPECT_LE(update.window.delay.p50_s, update.window.delay.max_s);
  EXPECT_NEAR(update.supply_v, 12.0, 0.1);
  ASSERT_TRUE(update.clock_bound_s);
  EXPECT_LT(*update.clock_bound_s, 5e-3);
  EXPECT_EQ(update.counters.lost, 0u);
  EXPECT_EQ(sink_.summary->frames.missing, 0u);
  EXPECT_GT(sink_.summary->frames.seen, 200u);
}

TEST_F(SyncWatch, TellsEventsOnceAndInOrder) {
  sync::BoardPlan plan = plan_of(2ms);
  plan.pulses = 20;
  sink_.on_update = [&](std::size_t count) {
    if (count == 1) link_->board()->start(plan);
    stop_ = count == 3;
  };
  run();
  EXPECT_THAT(sink_.kinds, ElementsAre("started", "stopped"));
  EXPECT_EQ(sink_.updates.back().state, sync::RunState::Idle);
  EXPECT_EQ(sink_.summary->frames.seen, 20u);
}

TEST_F(SyncWatch, OutlivesAPulledPlug) {
  sync::SyncBoard::open("", bus_).start(plan_of(2ms));
  sink_.on_update = [this](std::size_t count) {
    if (count == 1) plugged_.unplug();
    if (count == 2) {
      EXPECT_FALSE(sink_.updates.back().present);
      EXPECT_FALSE(sink_.updates.back().clock_bound_s);
      plugged_.plug();
    }
    if (count == 3) {
      ASSERT_NE(link_->board(), nullptr);
      link_->board()->start(plan_of(4ms));
    }
    stop_ = count == 4;
  };
  run();
  EXPECT_THAT(sink_.kinds, ElementsAre("gone", "back", "booted", "started"));
  EXPECT_NEAR(sink_.updates.back().window.rate_hz.value_or(0.0), 250.0, 1e-6);
  ASSERT_TRUE(sink_.updates.back().clock_bound_s);
  EXPECT_LT(*sink_.updates.back().clock_bound_s, 5e-3) << "of the new epoch's ticks";
  EXPECT_EQ(sink_.summary->counters.gone, 1u);
  EXPECT_EQ(sink_.summary->counters.resets, 1u);
}

TEST_F(SyncWatch, AResetAndALooseContactAreToldApart) {
  sync::SyncBoard::open("", bus_).start(plan_of(2ms));
  sink_.on_update = [this](std::size_t count) {
    if (count == 1) plugged_.reconnect();
    if (count == 2) plugged_.reset();
    stop_ = count == 3;
  };
  run();
  EXPECT_THAT(sink_.kinds, ElementsAre("gone", "back", "gone", "back", "booted"));
  EXPECT_EQ(sink_.summary->counters.resets, 1u);
  EXPECT_EQ(sink_.summary->frames.missing, 0u) << "what was missed is fetched";
}

TEST_F(SyncWatch, SaysWhyABoardCannotBeTakenUpAgain) {
  sink_.on_update = [this](std::size_t count) {
    if (count == 1) plugged_.unplug();
    if (count == 2) {
      plugged_.plug();
      plugged_.permitted = false;
    }
    if (count == 3) {
      EXPECT_THAT(sink_.updates.back().trouble, HasSubstr("no permission"));
      plugged_.permitted = true;
    }
    stop_ = count == 4;
  };
  run();
  EXPECT_THAT(sink_.kinds, ElementsAre("gone", "trouble", "back", "booted"));
}

TEST_F(SyncWatch, LossesAndLockoutsAreTold) {
  plugged_.forgets = true;
  sync::SyncBoard::open("", bus_).start(plan_of(2ms));
  sink_.on_update = [this](std::size_t count) {
    if (count == 1) plugged_.lose_next = 3;
    if (count == 2) plugged_.supply_mv = 14'500;
    if (count == 3) {
      EXPECT_TRUE(sink_.updates.back().supply_locked);
      plugged_.supply_mv = 12'000;
    }
    stop_ = count == 4;
  };
  run();
  EXPECT_THAT(sink_.kinds, ElementsAre("lost", "locked", "rearmed"));
  EXPECT_EQ(sink_.summary->counters.lost, 3u);
  EXPECT_EQ(sink_.summary->frames.missing, 3u);
  EXPECT_GT(sink_.summary->frames.locked, 10u);
  EXPECT_GT(sink_.summary->most_supply_v, 14.0);
  EXPECT_LT(sink_.summary->least_supply_v, 12.5);
}

TEST_F(SyncWatch, EndsByItself) {
  watch_options_.seconds = 0.3;
  run();
  EXPECT_NEAR(sink_.summary->seconds, 0.3, 0.25);
  EXPECT_EQ(sink_.updates.size(), 1u);
}

}  // namespace
}  // namespace glint::apps
