// SPDX-License-Identifier: MIT
// The self-test finds its wire by itself.
#include "host/apps/sync_selftest.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/usb-sync/plugged_board.hpp"
#include "usb-sync/error.hpp"

namespace glint::apps {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

class SyncSelfTest : public ::testing::Test {
 protected:
  SayLine say_ = [this](const std::string& line) { said_.push_back(line); };

  sync::PluggedBoard plugged_;
  sync::PluggedBus bus_{{&plugged_}};
  sync::SyncBoard board_ = sync::SyncBoard::open("", bus_);
  std::vector<std::string> said_;
};

TEST_F(SyncSelfTest, WithoutAPromptEachOutputIsTestedAsItIs) {
  plugged_.measured_wire = 1;
  const auto results = run_self_tests(board_, {.outputs = {0, 1}, .wait_for_wires = false}, say_);
  ASSERT_EQ(results.size(), 2u);
  EXPECT_EQ(results[0].seen, 0u);
  EXPECT_TRUE(results[1].passed()) << self_test_text(results[1]);
  EXPECT_EQ(said_.size(), 2u);
  EXPECT_EQ(self_test_verdict(results, false), "");
  EXPECT_THAT(self_test_verdict(results, true), HasSubstr("output 0"));
}

TEST_F(SyncSelfTest, WaitsForTheWireAndAsksForIt) {
  plugged_.measured_wire = 5;
  const auto results = run_self_tests(board_, {.outputs = {5, 0}}, [this](const std::string& line) {
    said_.push_back(line);
    if (line.starts_with("connect")) plugged_.measured_wire = 0;
  });
  ASSERT_EQ(results.size(), 2u);
  EXPECT_TRUE(results[0].passed()) << self_test_text(results[0]);
  EXPECT_TRUE(results[1].passed()) << self_test_text(results[1]);
  ASSERT_EQ(said_.size(), 3u) << "output 5 was wired already";
  EXPECT_THAT(said_[1], AllOf(HasSubstr("GP2"), HasSubstr("GP14")));
}

TEST_F(SyncSelfTest, ARunOrALockoutIsInTheWay) {
  plugged_.measured_wire = 0;
  sync::BoardPlan plan;
  plan.outputs[0] = {.enabled = true, .width = 100us};
  board_.start(plan);
  EXPECT_THROW(run_self_tests(board_, {.outputs = {0}}, say_), sync::Refused);
}

}  // namespace
}  // namespace glint::apps
