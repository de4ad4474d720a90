// SPDX-License-Identifier: MIT
// What the board refuses to do.
#include "firmware/core/plan.hpp"

#include <gtest/gtest.h>

namespace glint::board {
namespace {

class PlanTest : public ::testing::Test {
 protected:
  PlanTest() : plan(default_plan()) {
    for (const unsigned i : {0u, 4u}) plan.outputs[i].flags = GLINT_SYNC_OUTPUT_ENABLED;
  }
  void expect(std::uint8_t reason, unsigned output, std::uint32_t limit) const {
    const Refusal refusal = check(plan, limits, strobes_active_low);
    EXPECT_EQ(refusal.reason, reason);
    EXPECT_EQ(refusal.output, output);
    EXPECT_EQ(refusal.limit, limit);
  }
  void expect_taken() const { expect(GLINT_SYNC_REFUSED_NOTHING, 0xff, 0); }

  Plan plan;
  StrobeLimits limits;
  bool strobes_active_low = false;
};

TEST_F(PlanTest, TakesTheRigOfTheThesis) {
  plan.outputs[4].delay_ticks = ticks_of_us(788);
  plan.outputs[4].width_ticks = ticks_of_us(265);
  expect_taken();
}

TEST_F(PlanTest, WantsAnOutput) {
  plan.outputs[0].flags = plan.outputs[4].flags = 0;
  expect(GLINT_SYNC_REFUSED_NO_OUTPUT, 0xff, 0);
}

TEST_F(PlanTest, PeriodsAreFromHalfAMillisecondToTenSeconds) {
  plan.outputs[4].flags = 0;
  plan.run.period_ticks = ticks_of_us(500);
  expect_taken();
  plan.run.period_ticks -= 1;
  expect(GLINT_SYNC_REFUSED_PERIOD_SHORT, 0xff, ticks_of_us(500));
  plan.run.period_ticks = ticks_of_us(10'000'000);
  expect_taken();
  plan.run.period_ticks += 1;
  expect(GLINT_SYNC_REFUSED_PERIOD_LONG, 0xff, ticks_of_us(10'000'000));
}

TEST_F(PlanTest, AnOutputBeginsWithinItsFrameAndEndsBeforeTheNextButOne) {
  plan.outputs[4].flags = 0;
  plan.run.period_ticks = ticks_of_us(1000);
  plan.outputs[0].delay_ticks = ticks_of_us(999);
  plan.outputs[0].width_ticks = ticks_of_us(501);
  expect_taken();
  plan.outputs[0].width_ticks += 1;
  expect(GLINT_SYNC_REFUSED_WIDTH_LONG, 0, ticks_of_us(501));
  plan.outputs[0].delay_ticks = ticks_of_us(1000);
  expect(GLINT_SYNC_REFUSED_DELAY, 0, ticks_of_us(1000));
}

TEST_F(PlanTest, PulsesOfAnOutputHaveAGap) {
  plan.outputs[4].flags = 0;
  plan.run.period_ticks = ticks_of_us(1000);
  plan.outputs[0].width_ticks = ticks_of_us(999);
  expect_taken();
  plan.outputs[0].width_ticks += 1;
  expect(GLINT_SYNC_REFUSED_WIDTH_LONG, 0, ticks_of_us(999));
  plan.outputs[0].width_ticks = ticks_of_us(1) - 1;
  expect(GLINT_SYNC_REFUSED_WIDTH_SHORT, 0, ticks_of_us(1));
}

TEST_F(PlanTest, WithAnExternalTriggerAFrameIsOverBeforeTheNext) {
  plan.outputs[4].flags = 0;
  plan.run.flags = GLINT_SYNC_RUN_EXTERNAL;
  plan.run.period_ticks = ticks_of_us(1000);
  plan.outputs[0].delay_ticks = ticks_of_us(700);
  plan.outputs[0].width_ticks = ticks_of_us(299);
  expect_taken();
  plan.outputs[0].width_ticks += 1;
  expect(GLINT_SYNC_REFUSED_WIDTH_LONG, 0, ticks_of_us(299));
}

TEST_F(PlanTest, StrobesHaveAWidthCap) {
  plan.run.period_ticks = ticks_of_us(100'000);
  plan.outputs[4].width_ticks = ticks_of_us(300);
  expect_taken();
  plan.outputs[4].width_ticks += 1;
  expect(GLINT_SYNC_REFUSED_STROBE_WIDTH, 4, ticks_of_us(300));
}

TEST_F(PlanTest, StrobesHaveADutyCapThatCountsTheFramesInWhichTheyFire) {
  plan.run.period_ticks = ticks_of_us(4000);
  plan.outputs[4].width_ticks = ticks_of_us(100);  // 25 permille
  expect_taken();
  plan.outputs[4].width_ticks += 1;
  expect(GLINT_SYNC_REFUSED_STROBE_DUTY, 4, 25);
  plan.outputs[4].every_n = 2;
  expect_taken();
}

TEST_F(PlanTest, TriggersHaveNeither) {
  plan.outputs[4].flags = 0;
  plan.outputs[0].width_ticks = ticks_of_us(5000);
  expect_taken();
}

TEST_F(PlanTest, LowerLimitsOfTheHostCount) {
  limits.max_width = ticks_of_us(99);
  expect(GLINT_SYNC_REFUSED_STROBE_WIDTH, 4, ticks_of_us(99));
}

TEST_F(PlanTest, TheJumperDecidesThePolarityOfStrobes) {
  plan.outputs[4].flags |= GLINT_SYNC_OUTPUT_ACTIVE_LOW;
  expect(GLINT_SYNC_REFUSED_POLARITY, 4, 0);
  strobes_active_low = true;
  expect_taken();
  plan.outputs[4].flags = GLINT_SYNC_OUTPUT_ENABLED;
  expect(GLINT_SYNC_REFUSED_POLARITY, 4, 1);
}

TEST_F(PlanTest, PhasesAreBelowTheirNumberOfFrames) {
  plan.outputs[0].every_n = 3;
  plan.outputs[0].phase = 2;
  expect_taken();
  plan.outputs[0].phase = 3;
  expect(GLINT_SYNC_REFUSED_PHASE, 0, 3);
  plan.outputs[0].every_n = 0;
  expect(GLINT_SYNC_REFUSED_FORMAT, 0, 1);
}

TEST_F(PlanTest, CodesHaveGroupsOf18To1024Frames) {
  for (const std::uint16_t group : {std::uint16_t{0}, std::uint16_t{18}, std::uint16_t{1024}}) {
    plan.run.code_group = group;
    expect_taken();
  }
  plan.run.code_group = 17;
  expect(GLINT_SYNC_REFUSED_CODE, 0xff, 18);
  plan.run.code_group = 1025;
  expect(GLINT_SYNC_REFUSED_CODE, 0xff, 1024);
}

TEST_F(PlanTest, OutputsThatAreOffMayBeAnything) {
  plan.outputs[7].width_ticks = ~0u;
  plan.outputs[7].every_n = 0;
  expect_taken();
}

}  // namespace
}  // namespace glint::board
