// SPDX-License-Identifier: MIT
// Writes firmware into a board that waits in its bootloader, over USB and without a drive.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "usb-sync/picoboot.hpp"
#include "usb-sync/uf2.hpp"

namespace glint::sync {

/// A chip that waits in its bootloader (2e8a:0003).
struct FoundBootloader {
  std::string place;  ///< "1-4.2": bus and ports, as in /sys/bus/usb/devices
};

std::vector<FoundBootloader> find_bootloaders();

enum class FlashStep : std::uint8_t { Erase, Write, Verify, Reboot };
const char* step_text(FlashStep step) noexcept;
/// Called with how much of a step is done, 0 .. 1.
using FlashProgress = std::function<void(FlashStep step, double share)>;

/// The only bootloader, or the one at `place`. Throws Error: none, several (names their places), no
/// permission (names the udev rule), in use by another program.
std::unique_ptr<PicobootPort> open_bootloader(std::string_view place = {});

/// Erases, writes, reads back and compares, then restarts the chip into what was written. Throws Error that
/// says what to do: unplugged midway, refused by the chip, or a byte that reads back wrongly. Until the end
/// of the comparison the chip stays in its bootloader: calling again is safe.
void flash(PicobootPort& port, const FlashImage& image, const FlashProgress& progress = {});

}  // namespace glint::sync
