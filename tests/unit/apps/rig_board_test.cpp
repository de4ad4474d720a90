// SPDX-License-Identifier: MIT
// From the rig file to the board of a run.
#include "host/apps/rig_board.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/base/pulse_code.hpp"
#include "tests/unit/usb-sync/plugged_board.hpp"
#include "usb-sync/error.hpp"

namespace glint::apps {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(RigBoard, AllOutputsFireAsTheirKindUnlessTheFileSaysOtherwise) {
  Rig rig;
  rig.rate_hz = 120.0;
  rig.sync.code_seed = 7;
  SyncOutput off, other;
  off.output = 1;
  off.enabled = false;
  other.output = 6;
  other.delay_us = 900.0;
  other.every_n = 2;
  other.phase = 1;
  rig.sync.outputs = {off, other};
  const sync::BoardPlan plan = board_plan(rig);
  EXPECT_DOUBLE_EQ(plan.period.count(), 1.0 / 120.0);
  EXPECT_EQ(plan.keepalive, std::chrono::milliseconds(2000));
  EXPECT_EQ(plan.code.seed, 7u);
  EXPECT_EQ(plan.code.group, static_cast<int>(PulseCode::recommended_group(120.0)));
  EXPECT_TRUE(plan.outputs[0].enabled);
  EXPECT_DOUBLE_EQ(plan.outputs[0].width.count(), 100e-6);
  EXPECT_FALSE(plan.outputs[1].enabled);
  EXPECT_DOUBLE_EQ(plan.outputs[5].delay.count(), 788e-6);
  EXPECT_DOUBLE_EQ(plan.outputs[6].delay.count(), 900e-6);
  EXPECT_DOUBLE_EQ(plan.outputs[6].width.count(), 137e-6);
  EXPECT_EQ(plan.outputs[6].every_n, 2);
  EXPECT_EQ(plan.outputs[6].phase, 1);
}

TEST(RigBoard, AutoTakesTheBoardThatIsThereAndSaysSoIfThereIsNone) {
  sync::PluggedBoard board;
  sync::PluggedBus with({&board}), without({});
  Rig rig;
  rig.sync.board = "auto";
  std::vector<std::string> notes;
  EXPECT_NE(open_board(rig, notes, with), nullptr);
  EXPECT_EQ(open_board(rig, notes, without), nullptr);
  EXPECT_THAT(notes, ElementsAre(HasSubstr(board.serial_text()), HasSubstr("no sync board is plugged in")));
}

TEST(RigBoard, ABoardThatIsNamedMustBeThere) {
  sync::PluggedBoard board;
  sync::PluggedBus bus({&board});
  Rig rig;
  rig.sync.board = "0123456789ABCDEF";
  std::vector<std::string> notes;
  EXPECT_THROW((void)open_board(rig, notes, bus), sync::NoBoard);
  rig.sync.board = "none";
  EXPECT_EQ(open_board(rig, notes, bus), nullptr);
  EXPECT_TRUE(notes.empty());
}

}  // namespace
}  // namespace glint::apps
