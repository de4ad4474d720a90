// SPDX-License-Identifier: MIT
// Runs begun, changed and ended on the board's own logic.
#include "host/apps/sync_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/error.hpp"
#include "tests/unit/usb-sync/plugged_board.hpp"
#include "usb-sync/error.hpp"

namespace glint::apps {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

sync::BoardPlan plan_of(sync::Seconds period) {
  sync::BoardPlan plan;
  plan.period = period;
  plan.outputs[0] = {.enabled = true, .width = 100us};
  plan.outputs[4] = {.enabled = true, .delay = 788us, .width = 50us};
  return plan;
}

class SyncRun : public ::testing::Test {
 protected:
  sync::PluggedBoard plugged_;
  sync::PluggedBus bus_{{&plugged_}};
  sync::SyncBoard board_ = sync::SyncBoard::open("", bus_);
};

TEST_F(SyncRun, StartsAndSaysWhenTheFirstFrameComes) {
  const RunOutcome outcome = run_plan(board_, plan_of(sync::Seconds(1.0 / 90.0)));
  EXPECT_EQ(outcome.kind, RunOutcome::Kind::Started);
  EXPECT_EQ(outcome.run, 1);
  EXPECT_NEAR(outcome.plan.period.count(), 1388889 * 8e-9, 1e-12);
  ASSERT_TRUE(outcome.first_frame);
  EXPECT_GT(*outcome.first_frame, 400us);
  EXPECT_LT(*outcome.first_frame, 100ms);
  EXPECT_EQ(board_.status().state, sync::RunState::Running);
}

TEST_F(SyncRun, ARunUnderWayTakesThePlanOver) {
  run_plan(board_, plan_of(4ms));
  const RunOutcome outcome = run_plan(board_, plan_of(3ms));
  EXPECT_EQ(outcome.kind, RunOutcome::Kind::Applied);
  EXPECT_EQ(outcome.run, 1);
  ASSERT_TRUE(outcome.applied_sequence);
  EXPECT_GT(*outcome.applied_sequence, 0u);
  EXPECT_EQ(board_.status().applied_sequence, *outcome.applied_sequence);
}

TEST_F(SyncRun, WhatBeginsFramesChangesWithAnotherRunOnly) {
  run_plan(board_, plan_of(4ms));
  sync::BoardPlan external = plan_of(4ms);
  external.start = sync::FrameStart::RisingEdge;
  RunOutcome outcome = run_plan(board_, external);
  EXPECT_EQ(outcome.kind, RunOutcome::Kind::Restarted);
  EXPECT_EQ(outcome.previous_run, 1);
  EXPECT_EQ(outcome.run, 2);
  EXPECT_FALSE(outcome.first_frame);
  EXPECT_EQ(board_.status().state, sync::RunState::Waiting);
  external.outputs[0].active_low = true;
  outcome = run_plan(board_, external);
  EXPECT_EQ(outcome.kind, RunOutcome::Kind::Restarted);
  EXPECT_EQ(outcome.run, 3);
}

TEST_F(SyncRun, ARunThatWaitsForAnEdgeTakesThePlanOverLater) {
  sync::BoardPlan external = plan_of(4ms);
  external.start = sync::FrameStart::RisingEdge;
  run_plan(board_, external);
  external.outputs[4].width = 60us;
  const RunOutcome outcome = run_plan(board_, external);
  EXPECT_EQ(outcome.kind, RunOutcome::Kind::Applied);
  EXPECT_FALSE(outcome.applied_sequence);
}

TEST_F(SyncRun, ARefusedPlanLeavesTheStagedOneAndTheRun) {
  const sync::BoardPlan good = run_plan(board_, plan_of(4ms)).plan;
  sync::BoardPlan bad = plan_of(4ms);
  bad.outputs[4].width = 400us;
  EXPECT_THROW(run_plan(board_, bad), sync::Refused);
  EXPECT_EQ(board_.staged(), good);
  EXPECT_EQ(board_.status().state, sync::RunState::Running);
  EXPECT_EQ(board_.status().run, 1);
}

TEST_F(SyncRun, ARunThatEndedForARefusedPlanCanBeBegunAnew) {
  const sync::BoardPlan good = run_plan(board_, plan_of(4ms)).plan;
  sync::BoardPlan bad = plan_of(4ms);
  bad.start = sync::FrameStart::RisingEdge;
  bad.outputs[4].width = 400us;
  try {
    run_plan(board_, bad);
    FAIL() << "400 us are above the cap";
  } catch (const sync::Refused& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("run 1 had to end"));
  }
  EXPECT_EQ(board_.staged(), good);
  EXPECT_EQ(run_staged(board_).run, 2);
}

TEST_F(SyncRun, WhatIsStagedRunsIfAnythingIs) {
  try {
    run_staged(board_);
    FAIL() << "nothing is staged after power-up";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("--exposure"));
  }
  board_.stage(plan_of(4ms));
  EXPECT_EQ(run_staged(board_).kind, RunOutcome::Kind::Started);
  board_.stage(plan_of(5ms));
  const RunOutcome outcome = run_staged(board_);
  EXPECT_EQ(outcome.kind, RunOutcome::Kind::Applied);
  EXPECT_EQ(outcome.plan, board_.staged());
}

TEST_F(SyncRun, AChangeIsStagedAppliedOrBegun) {
  sync::BoardPlan plan = plan_of(4ms);
  EXPECT_FALSE(change_plan(board_, plan, false).run);
  EXPECT_EQ(board_.status().state, sync::RunState::Idle);
  EXPECT_EQ(board_.staged().outputs[4].enabled, true);
  EXPECT_EQ(change_plan(board_, plan, true).run->kind, RunOutcome::Kind::Started);
  plan.outputs[4].width = 60us;
  EXPECT_EQ(change_plan(board_, plan, false).run->kind, RunOutcome::Kind::Applied);
  plan.outputs[0].active_low = true;
  EXPECT_THROW(change_plan(board_, plan, false), sync::Refused) << "a change never ends a run";
  EXPECT_FALSE(board_.staged().outputs[0].active_low);
  EXPECT_EQ(board_.status().run, 1);
}

TEST_F(SyncRun, StopWaitsForTheLastFrame) {
  EXPECT_FALSE(stop_run(board_).was_running);
  run_plan(board_, plan_of(20ms));
  const StopOutcome outcome = stop_run(board_);
  EXPECT_TRUE(outcome.was_running);
  EXPECT_EQ(outcome.status.state, sync::RunState::Idle);
  EXPECT_EQ(outcome.status.run, 1);
  EXPECT_GE(outcome.status.sequence, 1u);
}

TEST_F(SyncRun, TheLockoutIsTold) {
  plugged_.supply_mv = 14'500;
  std::optional<RunOutcome> outcome;
  for (int i = 0; i < 50 && !board_.status().supply_locked; ++i) board_.read(5ms);
  outcome = run_plan(board_, plan_of(4ms));
  EXPECT_TRUE(outcome->supply_locked);
}

TEST_F(SyncRun, AResetBoardComesBackWithAnotherEpoch) {
  const std::uint32_t before = board_.info().epoch;
  const sync::Info after = reset_board(board_, bus_);
  EXPECT_NE(after.epoch, before);
  EXPECT_EQ(after.serial, plugged_.serial_text());
}

}  // namespace
}  // namespace glint::apps
