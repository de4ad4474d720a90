// SPDX-License-Identifier: MIT
#include "usb-sync/uf2.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <functional>
#include <random>

#include "tests/support/temp_dir.hpp"
#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

using Bytes = std::vector<std::uint8_t>;

void put(Bytes& file, std::size_t at, std::uint32_t value) { std::memcpy(&file[at], &value, 4); }

// Offsets in a block.
constexpr std::size_t kBlock = 512, kFlags = 8, kAddress = 12, kPayload = 16, kNumber = 20, kCount = 24,
                      kFamily = 28, kData = 32, kEnd = 508;

/// A whole file of so many blocks; the first holds a boot stage with the right checksum.
Bytes good_file(std::uint32_t blocks = 5) {
  Bytes file(blocks * kBlock, 0);
  std::mt19937 random(1);
  for (std::uint32_t i = 0; i < blocks; ++i) {
    const std::size_t at = i * kBlock;
    put(file, at, 0x0a324655);
    put(file, at + 4, 0x9e5d5157);
    put(file, at + kFlags, 0x2000);
    put(file, at + kAddress, 0x10000000 + 256 * i);
    put(file, at + kPayload, 256);
    put(file, at + kNumber, i);
    put(file, at + kCount, blocks);
    put(file, at + kFamily, 0xe48bff56);
    for (std::size_t b = 0; b < 256; ++b) file[at + kData + b] = static_cast<std::uint8_t>(random());
    put(file, at + kEnd, 0x0ab16f30);
  }
  put(file, kData + 252, boot_checksum(std::span(file).subspan(kData, 252)));
  return file;
}

std::string error_of(const Bytes& file) {
  try {
    parse_uf2(file, "board.uf2");
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

std::string error_after(const std::function<void(Bytes&)>& damage) {
  Bytes file = good_file();
  damage(file);
  return error_of(file);
}

TEST(Uf2, AGoodFileBecomesOneImage) {
  const Bytes file = good_file(3);
  const FlashImage image = parse_uf2(file, "board.uf2");
  EXPECT_EQ(image.address, 0x10000000u);
  ASSERT_EQ(image.bytes.size(), 768u);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_EQ(std::memcmp(&image.bytes[256 * i], &file[kBlock * i + kData], 256), 0);
  }
}

TEST(Uf2, BlocksMayComeInAnyOrder) {
  const Bytes file = good_file(2);
  Bytes swapped(file.begin() + kBlock, file.end());
  swapped.insert(swapped.end(), file.begin(), file.begin() + kBlock);
  EXPECT_EQ(parse_uf2(swapped, "board.uf2").bytes, parse_uf2(file, "board.uf2").bytes);
}

TEST(Uf2, WhatNoBlockWritesIsErasedFlash) {
  Bytes file = good_file(2);
  put(file, kBlock + kAddress, 0x10000000 + 1024);
  const FlashImage image = parse_uf2(file, "board.uf2");
  ASSERT_EQ(image.bytes.size(), 1280u);
  EXPECT_TRUE(std::all_of(&image.bytes[256], &image.bytes[1024], [](std::uint8_t b) { return b == 0xff; }));
}

TEST(Uf2, EveryErrorNamesTheFileAndWhatToDo) {
  EXPECT_THAT(error_of({}),
              AllOf(HasSubstr("board.uf2: the file is empty"), HasSubstr("take the .uf2 file")));
}

TEST(Uf2, ACutOffFileIsRefused) {
  EXPECT_THAT(error_after([](Bytes& f) { f.resize(f.size() - 100); }), HasSubstr("cut off"));
  EXPECT_THAT(error_after([](Bytes& f) { f.resize(f.size() - kBlock); }),
              HasSubstr("block 0 says that there are 5"));
}

TEST(Uf2, DamagedMarksAreRefused) {
  for (const std::size_t at : {std::size_t{0}, std::size_t{4}, kEnd}) {
    EXPECT_THAT(error_after([at](Bytes& f) { f[kBlock * 2 + at] ^= 1; }),
                HasSubstr("block 2 lacks the marks of a UF2 block"));
  }
}

TEST(Uf2, FilesForOtherChipsAreRefused) {
  const char* text = "block 1 is for another chip";
  EXPECT_THAT(error_after([](Bytes& f) { put(f, kBlock + kFamily, 0xe48bff59); }), HasSubstr(text));
  EXPECT_THAT(error_after([](Bytes& f) { put(f, kBlock + kFlags, 0); }), HasSubstr(text));
}

TEST(Uf2, BlocksThatAreNotForTheFlashAreRefused) {
  EXPECT_THAT(error_after([](Bytes& f) { put(f, kBlock + kFlags, 0x2001); }),
              HasSubstr("block 1 is not for the flash"));
  EXPECT_THAT(error_after([](Bytes& f) { put(f, kBlock + kFlags, 0x3000); }),
              HasSubstr("block 1 is not for the flash"));
  for (const std::uint32_t address : {0x0fffff00u, 0x11000000u, 0x20000000u, 0xffffff00u}) {
    EXPECT_THAT(error_after([=](Bytes& f) { put(f, 4 * kBlock + kAddress, address); }),
                HasSubstr("block 4 is for address 0x"));
  }
  EXPECT_THAT(error_after([](Bytes& f) { put(f, 4 * kBlock + kAddress, 0x10000480); }),
              HasSubstr("no multiple of 256"));
}

TEST(Uf2, OtherPayloadsAreRefused) {
  for (const std::uint32_t bytes : {0u, 255u, 476u, 0xffffffffu}) {
    EXPECT_THAT(error_after([=](Bytes& f) { put(f, kPayload, bytes); }),
                HasSubstr("block 0 holds " + std::to_string(bytes) + " bytes"));
  }
}

TEST(Uf2, NumbersMustBeThereOnceEach) {
  EXPECT_THAT(error_after([](Bytes& f) { put(f, 3 * kBlock + kNumber, 1); }),
              HasSubstr("block 3 has the number 1, which was there before"));
  EXPECT_THAT(error_after([](Bytes& f) { put(f, 3 * kBlock + kNumber, 5); }),
              HasSubstr("block 3 has the number 5, which is too high"));
}

TEST(Uf2, BlocksThatOverlapAreRefused) {
  EXPECT_THAT(error_after([](Bytes& f) { put(f, 3 * kBlock + kAddress, 0x10000100); }),
              AllOf(HasSubstr("blocks"), HasSubstr("are both for address 0x10000100")));
}

TEST(Uf2, WithoutABootStageTheChipWouldNotStart) {
  EXPECT_THAT(error_after([](Bytes& f) { put(f, kAddress, 0x10001000); }),
              HasSubstr("nothing is for the beginning of the flash, 0x10000000"));
  for (std::size_t i = 0; i < 256; ++i) {
    EXPECT_THAT(error_after([i](Bytes& f) { f[kData + i] ^= 0x40; }),
                HasSubstr("checksum of its boot stage"));
  }
}

TEST(Uf2, TheChecksumIsThatOfTheBootRom) {
  const std::string_view digits = "123456789";  // the check value of this CRC (CRC-32/MPEG-2)
  EXPECT_EQ(boot_checksum({reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()}),
            0x0376e6e7u);
}

TEST(Uf2, ReadsAFileAndSaysWhyItCannot) {
  const test::TempDir folder;
  const Bytes file = good_file();
  const auto path = folder.write("good.uf2", {reinterpret_cast<const char*>(file.data()), file.size()});
  EXPECT_EQ(read_uf2(path).bytes.size(), 5u * 256u);
  EXPECT_THROW(read_uf2(folder.path()), Error);
  try {
    read_uf2(folder.path() / "none.uf2");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("none.uf2: cannot be read"), HasSubstr("No such file")));
  }
}

TEST(Uf2, NoBytesAtAllBreakIt) {
  std::mt19937 random(3);
  for (int i = 0; i < 3000; ++i) {
    Bytes file = good_file(1 + random() % 4);
    for (std::size_t c = random() % 8; c > 0; --c) {
      file[random() % file.size()] = static_cast<std::uint8_t>(random());
    }
    if (random() % 4 == 0) file.resize(random() % file.size());
    try {
      EXPECT_LE(parse_uf2(file, "board.uf2").bytes.size(), kFlashMostBytes);
    } catch (const Error&) {
    }
  }
}

}  // namespace
}  // namespace glint::sync
