// SPDX-License-Identifier: MIT
#include "usb-sync/uf2.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

// github.com/microsoft/uf2: blocks of 512 bytes, little endian.
struct Block {
  std::uint32_t first_magic, second_magic, flags, address, payload_bytes, number, blocks, family;
  std::uint8_t data[476];
  std::uint32_t last_magic;
};
static_assert(sizeof(Block) == 512);

constexpr std::uint32_t kFirstMagic = 0x0a324655, kSecondMagic = 0x9e5d5157, kLastMagic = 0x0ab16f30;
constexpr std::uint32_t kNotFlash = 0x1, kContainer = 0x1000, kHasFamily = 0x2000;
constexpr std::uint32_t kRp2040 = 0xe48bff56;
/// The only size that the boot ROM's drive takes.
constexpr std::uint32_t kPayload = 256;
constexpr std::size_t kBootStage = 256;

std::string hex(std::uint32_t number) {
  std::string text = "0x";
  for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[number >> shift & 15u];
  return text;
}

/// What is wrong with a block by itself; "" if nothing is.
std::string flaw_of(const Block& block) {
  if (block.first_magic != kFirstMagic || block.second_magic != kSecondMagic ||
      block.last_magic != kLastMagic) {
    return "lacks the marks of a UF2 block";
  }
  if ((block.flags & kHasFamily) == 0 || block.family != kRp2040) {
    return "is for another chip, not for the RP2040";
  }
  if ((block.flags & (kNotFlash | kContainer)) != 0) return "is not for the flash";
  if (block.payload_bytes != kPayload) {
    return "holds " + std::to_string(block.payload_bytes) + " bytes; the RP2040 takes blocks of 256";
  }
  if (block.address < kFlashStart || block.address - kFlashStart > kFlashMostBytes - kPayload) {
    return "is for address " + hex(block.address) + ", which is outside of the flash";
  }
  if (block.address % kPayload != 0) return "is for address " + hex(block.address) + ", no multiple of 256";
  return "";
}

}  // namespace

FlashImage parse_uf2(std::span<const std::uint8_t> content, const std::string& file) {
  constexpr const char* kAdvice = ": take the .uf2 file that was built for the sync board, whole";
  const auto fail = [&](const std::string& text) { throw Error(file + ": " + text + kAdvice); };
  if (content.empty()) fail("the file is empty");
  if (content.size() % sizeof(Block) != 0) {
    fail("not a UF2 file, or cut off: its size of " + std::to_string(content.size()) +
         " bytes is no multiple of 512");
  }

  const std::size_t count = content.size() / sizeof(Block);
  std::vector<Block> blocks(count);
  std::memcpy(blocks.data(), content.data(), content.size());
  std::vector<bool> seen(count, false);
  for (std::size_t i = 0; i < count; ++i) {
    const Block& block = blocks[i];
    const std::string name = "block " + std::to_string(i) + " ";
    if (const std::string flaw = flaw_of(block); !flaw.empty()) fail(name + flaw);
    if (block.blocks != count) {
      fail(name + "says that there are " + std::to_string(block.blocks) + " blocks; the file has " +
           std::to_string(count));
    }
    if (block.number >= count || seen[block.number]) {
      fail(name + "has the number " + std::to_string(block.number) +
           (block.number >= count ? ", which is too high" : ", which was there before"));
    }
    seen[block.number] = true;
  }

  std::sort(blocks.begin(), blocks.end(),
            [](const Block& one, const Block& other) { return one.address < other.address; });
  const auto twice =
      std::adjacent_find(blocks.begin(), blocks.end(),
                         [](const Block& one, const Block& other) { return one.address == other.address; });
  if (twice != blocks.end()) {
    fail("blocks " + std::to_string(twice->number) + " and " + std::to_string(std::next(twice)->number) +
         " are both for address " + hex(twice->address));
  }
  if (blocks.front().address != kFlashStart)
    fail("nothing is for the beginning of the flash, " + hex(kFlashStart));

  FlashImage image;
  image.address = kFlashStart;
  image.bytes.assign(blocks.back().address + kPayload - kFlashStart, 0xff);
  for (const Block& block : blocks) {
    std::copy_n(block.data, kPayload, image.bytes.begin() + (block.address - kFlashStart));
  }
  const std::span<const std::uint8_t> boot = std::span(image.bytes).first(kBootStage);
  std::uint32_t stated = 0;
  std::memcpy(&stated, boot.last(4).data(), sizeof stated);
  if (stated != boot_checksum(boot.first(kBootStage - 4))) {
    fail("the checksum of its boot stage (block " + std::to_string(blocks.front().number) +
         ") is wrong, so that the chip would not start it");
  }
  return image;
}

FlashImage read_uf2(const std::filesystem::path& file) {
  if (std::filesystem::is_directory(file)) throw Error(file.string() + " is a folder, not a .uf2 file");
  std::ifstream stream(file, std::ios::binary);
  const std::vector<char> content{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
  if (!stream.is_open() || stream.bad()) {
    throw Error(file.string() + ": cannot be read (" + std::strerror(errno) + ")");
  }
  return parse_uf2({reinterpret_cast<const std::uint8_t*>(content.data()), content.size()}, file.string());
}

std::uint32_t boot_checksum(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t checksum = 0xffffffff;
  for (const std::uint8_t byte : bytes) {
    checksum ^= static_cast<std::uint32_t>(byte) << 24;
    for (int bit = 0; bit < 8; ++bit) checksum = checksum << 1 ^ ((checksum >> 31) != 0 ? 0x04c11db7u : 0u);
  }
  return checksum;
}

}  // namespace glint::sync
