// SPDX-License-Identifier: MIT
// Boards in the lists of `glint devices` and `glint doctor`.
#include "host/apps/sync_board_list.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/usb-sync/plugged_board.hpp"

namespace glint::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class SyncBoardList : public ::testing::Test {
 protected:
  SyncBoardList() { second_.permitted = false; }
  sync::PluggedBoard first_{8}, second_{9};
  sync::PluggedBus bus_{{&first_, &second_}};
};

TEST_F(SyncBoardList, ALineForEachBoard) {
  const std::string text = sync_boards_text(bus_);
  EXPECT_THAT(text, HasSubstr(first_.serial_text() +
                              " at /dev/hidraw8  firmware 0.2.3 (abcdef0123), protocol 1.0, idle\n"));
  EXPECT_THAT(text, HasSubstr(second_.serial_text() + " at /dev/hidraw9  no permission"));
}

TEST_F(SyncBoardList, Json) {
  nlohmann::ordered_json json;
  add_sync_boards(json, bus_);
  ASSERT_EQ(json["sync_boards"].size(), 2u);
  EXPECT_EQ(json["sync_boards"][0]["info"]["firmware"], "0.2.3");
  EXPECT_EQ(json["sync_boards"][0]["problem"], "");
  EXPECT_THAT(json["sync_boards"][1]["problem"].get<std::string>(), HasSubstr("no permission"));
  EXPECT_FALSE(json["sync_boards"][1].contains("info"));
}

TEST_F(SyncBoardList, FindingsForTheDoctor) {
  const Findings findings = check_sync_boards(bus_, {"1-4.2"}, "0.2.3");
  ASSERT_EQ(findings.size(), 3u);
  EXPECT_EQ(findings[0].verdict, Verdict::Ok);
  EXPECT_THAT(findings[0].text, AllOf(HasSubstr("0.2.3"), HasSubstr("protocol 1.0")));
  EXPECT_EQ(findings[0].advice, "");
  EXPECT_EQ(findings[1].verdict, Verdict::Warning);
  EXPECT_THAT(findings[1].text, HasSubstr("no permission"));
  EXPECT_THAT(findings[2].text, HasSubstr("1-4.2"));
  EXPECT_THAT(check_sync_boards(bus_, {}, "0.3.0")[0].advice, HasSubstr("0.3.0"));
}

TEST_F(SyncBoardList, NothingWithoutABoard) {
  first_.unplug();
  second_.unplug();
  EXPECT_TRUE(check_sync_boards(bus_, {}, "0.2.3").empty());
  EXPECT_EQ(sync_boards_text(bus_), "");
}

}  // namespace
}  // namespace glint::apps
