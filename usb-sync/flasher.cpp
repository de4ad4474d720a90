// SPDX-License-Identifier: MIT
#include "usb-sync/flasher.hpp"

#include <algorithm>
#include <array>
#include <cstdio>

#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

/// Bytes at a time: small enough that progress shows.
constexpr std::size_t kChunk = 4 * Picoboot::kSectorBytes;

std::string hex(std::uint32_t number, int digits) {
  char text[16];
  std::snprintf(text, sizeof text, "0x%0*x", digits, number);
  return text;
}

std::size_t rounded_up(std::size_t bytes, std::size_t unit) { return (bytes + unit - 1) / unit * unit; }

void compare(std::uint32_t address, std::span<const std::uint8_t> wanted,
             std::span<const std::uint8_t> read) {
  const auto [want, got] = std::mismatch(wanted.begin(), wanted.end(), read.begin());
  if (want == wanted.end()) return;
  const auto offset = static_cast<std::uint32_t>(want - wanted.begin());
  throw Error("verify: the flash holds " + hex(*got, 2) + " at address " + hex(address + offset, 8) +
              ", not " + hex(*want, 2) + ": flash again; if that does not help, the board is defective");
}

}  // namespace

const char* step_text(FlashStep step) noexcept {
  switch (step) {
    case FlashStep::Erase:
      return "erase";
    case FlashStep::Write:
      return "write";
    case FlashStep::Verify:
      return "verify";
    case FlashStep::Reboot:
      return "reboot";
  }
  return "unknown";
}

void flash(PicobootPort& port, const FlashImage& image, const FlashProgress& progress) {
  if (image.bytes.empty() || image.address % Picoboot::kSectorBytes != 0) {
    throw Error("the firmware is empty, or does not begin with a sector of the flash");
  }
  std::vector<std::uint8_t> bytes = image.bytes;
  bytes.resize(rounded_up(bytes.size(), Picoboot::kSectorBytes), 0xff);
  const auto in_chunks = [&](FlashStep step, std::size_t from, auto&& work) {
    for (std::size_t at = from; at < bytes.size(); at += kChunk) {
      if (progress) progress(step, static_cast<double>(at) / static_cast<double>(bytes.size()));
      work(image.address + static_cast<std::uint32_t>(at),
           std::span<const std::uint8_t>(bytes).subspan(at, std::min(kChunk, bytes.size() - at)));
    }
    if (progress) progress(step, 1.0);
  };

  Picoboot chip(port);
  chip.take_exclusively();
  chip.exit_xip();
  const auto write = [&](std::uint32_t address, std::span<const std::uint8_t> part) {
    chip.write(address, part);
  };
  const auto verify = [&](std::uint32_t address, std::span<const std::uint8_t> part) {
    std::array<std::uint8_t, kChunk> read;
    chip.read(address, std::span(read).first(part.size()));
    compare(address, part, read);
  };
  in_chunks(FlashStep::Erase, 0, [&](std::uint32_t address, std::span<const std::uint8_t> part) {
    chip.erase(address, static_cast<std::uint32_t>(part.size()));
  });
  // The first sector, without which the ROM starts nothing, comes last: whenever the power goes, the chip is
  // either wholly flashed or back in its bootloader.
  in_chunks(FlashStep::Write, Picoboot::kSectorBytes, write);
  in_chunks(FlashStep::Verify, Picoboot::kSectorBytes, verify);
  const auto first = std::span<const std::uint8_t>(bytes).first(Picoboot::kSectorBytes);
  write(image.address, first);
  verify(image.address, first);
  constexpr std::chrono::milliseconds kUntilItsAnswerIsOut{500};
  if (progress) progress(FlashStep::Reboot, 0.0);
  chip.reboot(kUntilItsAnswerIsOut);
  if (progress) progress(FlashStep::Reboot, 1.0);
}

}  // namespace glint::sync
