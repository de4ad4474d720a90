// SPDX-License-Identifier: MIT
#include "usb-sync/flasher.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <deque>
#include <random>

#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using Bytes = std::vector<std::uint8_t>;

/// The boot ROM's end: flash that must be erased before it is written, commands that must come in order.
class BootRom final : public PicobootPort {
 public:
  Result send(std::span<const std::uint8_t> bytes) noexcept override {
    if (const Result result = trouble(); result != Result::Done) return result;
    if (data_left_ > 0) return take_data(bytes);
    if (acknowledge_out_) {
      acknowledge_out_ = false;
      return bytes.empty() ? Result::Done : stall(3);
    }
    return take_command(bytes);
  }

  Result receive(std::span<std::uint8_t> bytes) noexcept override {
    if (const Result result = trouble(); result != Result::Done) return result;
    if (acknowledge_in_) {
      acknowledge_in_ = false;
      return bytes.empty() ? Result::Done : stall(3);
    }
    if (bytes.size() != data_left_ || data_left_ == 0) return stall(3);
    std::copy_n(&flash[address_], bytes.size(), bytes.begin());
    data_left_ = 0;
    acknowledge_out_ = true;
    return Result::Done;
  }

  Result reset_interface() noexcept override {
    ++resets;
    stalled_ = acknowledge_in_ = acknowledge_out_ = false;
    data_left_ = 0;
    return gone_after == 0 ? Result::Gone : Result::Done;
  }

  Result command_status(std::span<std::uint8_t, 16> status) noexcept override {
    std::fill(status.begin(), status.end(), std::uint8_t{0});
    std::memcpy(&status[4], &error_, 4);
    return Result::Done;
  }

  Bytes flash = Bytes(2u << 20, 0x55);
  std::size_t gone_after = 1'000'000;  // transfers
  std::size_t dies_at = SIZE_MAX;      // a byte of the flash that cannot be written
  int resets = 0;
  bool rebooted = false, exclusive = false, xip_left = false;

 private:
  Result trouble() noexcept {
    if (gone_after == 0) return Result::Gone;
    --gone_after;
    return stalled_ ? Result::Stalled : Result::Done;
  }
  Result stall(std::uint32_t error) noexcept {
    stalled_ = true;
    error_ = error;
    return Result::Stalled;
  }

  Result take_command(std::span<const std::uint8_t> bytes) noexcept {
    std::uint32_t magic = 0, token = 0, length = 0, arguments[4] = {};
    if (bytes.size() != 32) return stall(2);
    std::memcpy(&magic, &bytes[0], 4);
    std::memcpy(&token, &bytes[4], 4);
    std::memcpy(&length, &bytes[12], 4);
    std::memcpy(arguments, &bytes[16], 16);
    if (magic != 0x431fd10b || token == last_token_) return stall(1);
    last_token_ = token;
    const auto command = bytes[8], argument_bytes = bytes[9];
    const bool ranged = command == 0x03 || command == 0x05 || command == 0x84;
    if (argument_bytes != (ranged ? 8 : command == 0x01 ? 1 : command == 0x02 ? 12 : 0)) return stall(2);
    if (ranged) {
      if (arguments[0] < 0x10000000 || arguments[0] - 0x10000000 + arguments[1] > flash.size())
        return stall(4);
      address_ = arguments[0] - 0x10000000;
      const std::uint32_t grain = command == 0x03 ? 4096 : command == 0x05 ? 256 : 1;
      if (arguments[0] % grain != 0 || arguments[1] % grain != 0) return stall(5);
      if (!exclusive || !xip_left) return stall(8);
    }
    acknowledge_in_ = command != 0x84;
    switch (command) {
      case 0x01:
        exclusive = bytes[16] == 1;
        return length == 0 ? Result::Done : stall(3);
      case 0x02:
        rebooted = arguments[0] == 0;
        return Result::Done;
      case 0x03:
        std::fill_n(&flash[address_], arguments[1], std::uint8_t{0xff});
        return Result::Done;
      case 0x05:
      case 0x84:
        data_left_ = arguments[1];
        return length == data_left_ ? Result::Done : stall(3);
      case 0x06:
        xip_left = true;
        return Result::Done;
      default:
        return stall(1);
    }
  }

  Result take_data(std::span<const std::uint8_t> bytes) noexcept {
    if (bytes.size() != data_left_) return stall(3);
    for (std::size_t i = 0; i < bytes.size(); ++i) {
      if (address_ + i != dies_at) flash[address_ + i] &= bytes[i];  // writing only clears bits
    }
    data_left_ = 0;
    return Result::Done;
  }

  std::uint32_t last_token_ = 0, error_ = 0;
  std::size_t address_ = 0, data_left_ = 0;
  bool stalled_ = false, acknowledge_in_ = false, acknowledge_out_ = false;
};

FlashImage firmware(std::size_t bytes) {
  FlashImage image{kFlashStart, Bytes(bytes)};
  std::mt19937 random(1);
  for (std::uint8_t& byte : image.bytes) byte = static_cast<std::uint8_t>(random());
  return image;
}

std::string error_of(BootRom& rom, const FlashImage& image) {
  try {
    flash(rom, image);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(Flasher, ErasesWritesVerifiesAndRestarts) {
  BootRom rom;
  const FlashImage image = firmware(20'480 + 256);
  flash(rom, image);
  EXPECT_TRUE(std::equal(image.bytes.begin(), image.bytes.end(), rom.flash.begin()));
  EXPECT_EQ(rom.flash[image.bytes.size()], 0xff);  // the rest of the last sector is erased
  EXPECT_EQ(rom.flash[6 * 4096], 0x55);            // and nothing behind it is touched
  EXPECT_TRUE(rom.rebooted);
  EXPECT_EQ(rom.resets, 1);
}

TEST(Flasher, TellsHowFarItIs) {
  BootRom rom;
  std::vector<std::pair<FlashStep, double>> told;
  flash(rom, firmware(100'000 / 256 * 256),
        [&](FlashStep step, double share) { told.emplace_back(step, share); });
  ASSERT_FALSE(told.empty());
  EXPECT_TRUE(std::is_sorted(told.begin(), told.end()));
  EXPECT_EQ(told.front(), std::make_pair(FlashStep::Erase, 0.0));
  EXPECT_EQ(told.back(), std::make_pair(FlashStep::Reboot, 1.0));
  for (const FlashStep step : {FlashStep::Erase, FlashStep::Write, FlashStep::Verify}) {
    EXPECT_GT(std::count_if(told.begin(), told.end(), [=](const auto& t) { return t.first == step; }), 5);
    EXPECT_NE(std::find(told.begin(), told.end(), std::make_pair(step, 1.0)), told.end());
  }
}

TEST(Flasher, AByteThatReadsBackWronglyIsNamedAndTheChipIsNotRestarted) {
  BootRom rom;
  rom.dies_at = 5000;
  EXPECT_THAT(error_of(rom, firmware(8192)), AllOf(HasSubstr("verify"), HasSubstr("address 0x10001388")));
  EXPECT_FALSE(rom.rebooted);
}

TEST(Flasher, UnpluggedAtAnyMomentItSaysSo) {
  BootRom whole;
  flash(whole, firmware(8192));
  const std::size_t transfers = 1'000'000 - whole.gone_after;
  ASSERT_GT(transfers, 10u);
  for (std::size_t after = 0; after < transfers; ++after) {
    BootRom rom;
    rom.gone_after = after;
    EXPECT_THAT(error_of(rom, firmware(8192)), AllOf(HasSubstr("unplugged"), HasSubstr("BOOTSEL"))) << after;
  }
}

TEST(Flasher, UnpluggedAtAnyMomentTheChipIsWholeOrStillInItsBootloader) {
  const FlashImage image = firmware(5 * 4096);
  BootRom whole;
  whole.flash.assign(whole.flash.size(), 0xff);
  flash(whole, image);
  const std::size_t transfers = 1'000'000 - whole.gone_after;
  for (std::size_t after = 0; after < transfers; ++after) {
    BootRom rom;
    rom.gone_after = after;
    (void)error_of(rom, image);
    // The ROM starts what begins with 256 bytes and their checksum, and looks no further.
    const bool starts = std::equal(image.bytes.begin(), image.bytes.begin() + 256, rom.flash.begin());
    const bool is_whole = std::equal(image.bytes.begin() + 4096, image.bytes.end(), rom.flash.begin() + 4096);
    EXPECT_TRUE(!starts || is_whole) << after;
  }
}

TEST(Flasher, WhatTheChipRefusesIsExplained) {
  BootRom rom;
  rom.flash.resize(64 * 1024);
  EXPECT_THAT(error_of(rom, firmware(128 * 1024)),
              AllOf(HasSubstr("erasing 16384 bytes at flash offset 65536"), HasSubstr("address outside")));
  EXPECT_FALSE(rom.rebooted);
}

TEST(Flasher, AfterAnErrorItCanBeDoneAgain) {
  BootRom rom;
  const FlashImage image = firmware(8192);
  rom.dies_at = 100;
  EXPECT_NE(error_of(rom, image), "no error");
  rom.dies_at = SIZE_MAX;
  EXPECT_EQ(error_of(rom, image), "no error");
  EXPECT_TRUE(std::equal(image.bytes.begin(), image.bytes.end(), rom.flash.begin()));
}

TEST(Flasher, NothingToWriteIsAnErrorBeforeAnythingIsTouched) {
  BootRom rom;
  EXPECT_NE(error_of(rom, {kFlashStart, {}}), "no error");
  EXPECT_NE(error_of(rom, {kFlashStart + 256, Bytes(256)}), "no error");
  EXPECT_EQ(rom.resets, 0);
}

}  // namespace
}  // namespace glint::sync
