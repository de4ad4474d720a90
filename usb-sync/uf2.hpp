// SPDX-License-Identifier: MIT
// Reads UF2 files of firmware for the board.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace glint::sync {

/// What goes into the flash: without holes, from `address` on.
struct FlashImage {
  std::uint32_t address = 0;
  std::vector<std::uint8_t> bytes;
};

/// Start of the RP2040's flash in its address space, and the most that it can address.
inline constexpr std::uint32_t kFlashStart = 0x10000000;
inline constexpr std::uint32_t kFlashMostBytes = 16u << 20;

/// Throws Error that names `file` and the block: not a UF2 file, cut off, for another chip, outside of the
/// flash, blocks that overlap, lack or contradict each other, no boot stage whose checksum is right (the chip
/// would not start it). Bytes that no block writes, inside, are 0xff.
FlashImage parse_uf2(std::span<const std::uint8_t> content, const std::string& file);

/// Throws Error also if the file cannot be read.
FlashImage read_uf2(const std::filesystem::path& file);

/// CRC-32 with polynomial 0x04c11db7, from 0xffffffff, most significant bit first: the boot ROM's.
std::uint32_t boot_checksum(std::span<const std::uint8_t> bytes) noexcept;

}  // namespace glint::sync
