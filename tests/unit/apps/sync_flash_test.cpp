// SPDX-License-Identifier: MIT
// The way into the bootloader and back, with whatever may be plugged in.
#include "host/apps/sync_flash.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/base/error.hpp"
#include "tests/unit/usb-sync/plugged_board.hpp"
#include "usb-sync/error.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint::apps {
namespace {

using namespace std::chrono_literals;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;

/// The smallest file that the flasher takes: a boot stage with its checksum.
std::vector<std::uint8_t> smallest_uf2() {
  std::vector<std::uint8_t> block(512, 0);
  const auto put = [&block](std::size_t at, std::uint32_t value) {
    std::memcpy(&block[at], &value, sizeof value);
  };
  put(0, 0x0a324655);
  put(4, 0x9e5d5157);
  put(8, 0x2000);
  put(12, 0x10000000);
  put(16, 256);
  put(20, 0);
  put(24, 1);
  put(28, 0xe48bff56);
  put(32 + 252, sync::boot_checksum(std::span(block).subspan(32, 252)));
  put(508, 0x0ab16f30);
  return block;
}

class Observer final : public FlashObserver {
 public:
  bool confirm(const sync::Info& board) override {
    asked = board.serial;
    return agrees;
  }
  void progress(const std::string& text) override { said.push_back(text); }

  bool agrees = true;
  std::string asked;
  std::vector<std::string> said;
};

class SyncFlash : public ::testing::Test {
 protected:
  SyncFlash() {
    options_.file = ::testing::TempDir() + "glint_sync_flash_test.uf2";
    const std::vector<std::uint8_t> content = smallest_uf2();
    std::ofstream(options_.file, std::ios::binary)
        .write(reinterpret_cast<const char*>(content.data()), static_cast<std::streamsize>(content.size()));
    calls_.find = [this] {
      std::vector<sync::FoundBootloader> found = others_;
      if (!plugged_.present && boots_) found.push_back({"1-4.2"});
      return found;
    };
    calls_.flash = [this](std::string_view place, const sync::FlashImage& image,
                          const sync::FlashProgress& progress) {
      if (refusals_ > 0) {
        --refusals_;
        throw sync::Error("no permission yet");
      }
      flashed_ = place;
      EXPECT_EQ(image.bytes.size(), 256u);
      progress(sync::FlashStep::Write, 0.5);
      if (breaks_) throw sync::Error("write: unplugged");
      progress(sync::FlashStep::Write, 1.0);
      if (comes_back_) plugged_.plug();
    };
  }
  ~SyncFlash() override { std::filesystem::remove(options_.file); }

  std::optional<FlashOutcome> flash() {
    return flash_board(options_, observer_, bus_, calls_,
                       {.bootloader = 100ms, .board = 100ms, .permission = 100ms, .look = 5ms});
  }
  std::string trouble() {
    try {
      flash();
    } catch (const std::exception& error) {
      return error.what();
    }
    return "";
  }

  sync::PluggedBoard plugged_, second_{9};
  sync::PluggedBus bus_{{&plugged_, &second_}};
  FlashOptions options_;
  BootloaderCalls calls_;
  Observer observer_;
  std::vector<sync::FoundBootloader> others_;
  bool boots_ = true, comes_back_ = true, breaks_ = false;
  int refusals_ = 0;
  std::string flashed_;
};

class SyncFlashOne : public SyncFlash {
 protected:
  SyncFlashOne() { second_.unplug(); }
};

TEST_F(SyncFlashOne, ARunningBoardGoesThroughItsBootloader) {
  refusals_ = 3;  // udev takes a moment
  const auto outcome = flash();
  ASSERT_TRUE(outcome);
  EXPECT_EQ(observer_.asked, plugged_.serial_text());
  EXPECT_EQ(flashed_, "1-4.2");
  ASSERT_TRUE(outcome->before);
  EXPECT_EQ(outcome->before->serial, outcome->after.serial);
  EXPECT_NE(outcome->before->epoch, outcome->after.epoch);
  EXPECT_THAT(observer_.said, AllOf(Contains("write 50 %"), Contains("write 100 %")));
}

TEST_F(SyncFlashOne, NothingHappensWithoutConsent) {
  observer_.agrees = false;
  EXPECT_FALSE(flash());
  EXPECT_TRUE(plugged_.present);
  EXPECT_EQ(flashed_, "");
}

TEST_F(SyncFlashOne, ABoardInItsBootloaderIsFlashedAtOnce) {
  plugged_.unplug();
  const auto outcome = flash();
  ASSERT_TRUE(outcome);
  EXPECT_FALSE(outcome->before);
  EXPECT_EQ(observer_.asked, "");
  EXPECT_EQ(outcome->after.serial, plugged_.serial_text());
}

TEST_F(SyncFlashOne, ARunIsNotInterruptedUnlessForced) {
  {
    sync::SyncBoard board = sync::SyncBoard::open("", bus_);
    sync::BoardPlan plan;
    plan.outputs[0] = {.enabled = true, .width = 100us};
    board.start(plan);
  }
  EXPECT_THAT(trouble(), AllOf(HasSubstr("running"), HasSubstr("--force")));
  EXPECT_TRUE(plugged_.present);
  options_.force = true;
  EXPECT_TRUE(flash());
}

TEST_F(SyncFlashOne, ABoardThatCannotBeTalkedToIsSentToBootsel) {
  plugged_.protocol = GLINT_SYNC_PROTOCOL_MAJOR + 1;
  EXPECT_THAT(trouble(), HasSubstr("BOOTSEL"));
}

TEST_F(SyncFlashOne, NoBootloaderComes) {
  boots_ = false;
  EXPECT_THAT(trouble(), AllOf(HasSubstr("did not come up in its bootloader"), HasSubstr("BOOTSEL")));
}

TEST_F(SyncFlashOne, TheBoardDoesNotComeBack) {
  comes_back_ = false;
  EXPECT_THAT(trouble(), AllOf(HasSubstr(options_.file), HasSubstr("no sync board has come up")));
}

TEST_F(SyncFlashOne, TheNewFirmwareSpeaksAnotherProtocol) {
  plugged_.unplug();
  plugged_.protocol = GLINT_SYNC_PROTOCOL_MAJOR + 1;
  EXPECT_THAT(trouble(), AllOf(HasSubstr("the board cannot be used"), HasSubstr("protocol")));
}

TEST_F(SyncFlashOne, WhatBreaksMidwayIsNotTriedAgain) {
  breaks_ = true;
  EXPECT_THAT(trouble(), HasSubstr("write: unplugged"));
}

TEST_F(SyncFlashOne, PermissionThatNeverComesIsTold) {
  refusals_ = 1000;
  EXPECT_THAT(trouble(), HasSubstr("no permission yet"));
}

TEST_F(SyncFlashOne, TheFileIsReadFirst) {
  std::filesystem::resize_file(options_.file, 100);
  EXPECT_THAT(trouble(), HasSubstr(options_.file));
  EXPECT_TRUE(plugged_.present);
}

TEST_F(SyncFlash, OfSeveralBoardsOneMustBeNamed) {
  EXPECT_THAT(trouble(), AllOf(HasSubstr(plugged_.serial_text()), HasSubstr(second_.serial_text())));
  options_.serial = plugged_.serial_text();
  EXPECT_EQ(flash()->after.serial, plugged_.serial_text());
}

TEST_F(SyncFlash, ABoardBesideABootloaderIsAQuestion) {
  others_ = {{"1-1"}};
  EXPECT_THAT(trouble(), AllOf(HasSubstr("--place 1-1"), HasSubstr("--board")));
  options_.serial = plugged_.serial_text();
  EXPECT_TRUE(flash());
  EXPECT_EQ(flashed_, "1-4.2") << "the one that came, not the one that was there";
}

TEST_F(SyncFlash, NothingThere) {
  plugged_.unplug();
  second_.unplug();
  boots_ = false;
  EXPECT_THAT(trouble(), AllOf(HasSubstr("no sync board is plugged in"), HasSubstr("BOOTSEL")));
  options_.serial = "AB";
  others_ = {{"1-1"}};
  EXPECT_THAT(trouble(), AllOf(HasSubstr("1-1"), HasSubstr("leave out --board")));
}

}  // namespace
}  // namespace glint::apps
