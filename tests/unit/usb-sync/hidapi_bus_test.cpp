// SPDX-License-Identifier: MIT
// The machine's boards as hidapi finds and uses them. The board's logic is the firmware's.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/usb-sync/mocked_machine.hpp"
#include "tests/unit/usb-sync/plugged_board.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint::sync {
namespace {

using namespace std::chrono_literals;
using testing::MockedMachine;

class HidapiBusTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!MockedMachine::available())
      GTEST_SKIP() << "umockdev is not preloaded (ctest does, or umockdev-wrapper)";
    machine_.emplace();
    port_ = logic_bus_.open(logic_.found());
    machine_->on_get = [this](std::span<std::uint8_t> report) { return port_->get_feature(report); };
    machine_->on_set = [this](std::span<std::uint8_t> report) { return port_->set_feature(report) ? 0 : -1; };
  }

  PluggedBoard logic_;
  PluggedBus logic_bus_{{&logic_}};
  std::unique_ptr<HidPort> port_;
  std::optional<MockedMachine> machine_;
};

TEST_F(HidapiBusTest, FindsBoardsByIdsNameAndUsage) {
  EXPECT_TRUE(find_boards().empty());
  machine_->plug(0, {"BBB", GLINT_SYNC_PRODUCT});
  machine_->plug(1, {"AAA", GLINT_SYNC_PRODUCT});
  machine_->plug(2, {"CCC", "somebody's keyboard"});
  machine_->plug(3, {"DDD", GLINT_SYNC_PRODUCT, "0002"});
  machine_->plug(4, {"EEE", GLINT_SYNC_PRODUCT, "0001", "0100"});
  const auto boards = find_boards();
  ASSERT_EQ(boards.size(), 2u);
  EXPECT_EQ(boards[0].serial, "AAA");
  EXPECT_EQ(boards[0].path, "/dev/hidraw1");
  EXPECT_EQ(boards[1].serial, "BBB");
}

TEST_F(HidapiBusTest, CommandsAndRefusalsPassTheKernel) {
  machine_->plug(0, {logic_.serial_text(), GLINT_SYNC_PRODUCT});
  SyncBoard board = SyncBoard::open();
  EXPECT_EQ(board.info().build, "abcdef0123");
  BoardPlan plan;
  plan.outputs[4] = {.enabled = true, .width = 301us};
  try {
    board.start(plan);
    FAIL();
  } catch (const Refused& refused) {
    EXPECT_EQ(refused.reason(), GLINT_SYNC_REFUSED_STROBE_WIDTH);
  }
  plan.outputs[4].width = 137us;
  board.start(plan);
  EXPECT_EQ(board.status().state, RunState::Running);
  EXPECT_TRUE(board.ask_time());
  board.stop();
}

TEST_F(HidapiBusTest, ReportsArriveWhole) {
  machine_->plug(0, {logic_.serial_text(), GLINT_SYNC_PRODUCT});
  SyncBoard board = SyncBoard::open();
  EXPECT_EQ(board.read(5ms).kind, ReadResult::Kind::Nothing);
  std::vector<std::uint8_t> report(64);
  const int length = port_->read(report, 100ms);  // BOOTED
  ASSERT_EQ(length, GLINT_SYNC_REPORT_BYTES);
  machine_->send(0, std::span(report).first(GLINT_SYNC_REPORT_BYTES));
  const ReadResult result = board.read(1000ms);
  ASSERT_EQ(result.kind, ReadResult::Kind::Report);
  EXPECT_EQ(std::get<Event>(result.report.content).kind, Event::Kind::Booted);
  machine_->send(0, std::span(report).first(20));
  EXPECT_EQ(board.read(1000ms).flaw, Flaw::Length);
}

TEST_F(HidapiBusTest, AnUnpluggedBoardIsGone) {
  machine_->plug(0, {logic_.serial_text(), GLINT_SYNC_PRODUCT});
  SyncBoard board = SyncBoard::open();
  machine_->unplug(0);
  EXPECT_EQ(board.read(100ms).kind, ReadResult::Kind::Gone);
  EXPECT_THROW(board.status(), BoardGone);
  EXPECT_THROW(SyncBoard::open(), NoBoard);
}

}  // namespace
}  // namespace glint::sync
