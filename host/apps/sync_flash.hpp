// SPDX-License-Identifier: MIT
// Putting firmware onto a sync board: into the bootloader, write, back again.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "usb-sync/board_state.hpp"
#include "usb-sync/flasher.hpp"
#include "usb-sync/hid_port.hpp"

namespace glint::apps {

struct FlashOptions {
  std::string file;    ///< .uf2
  std::string serial;  ///< of the board; "": the only one
  std::string place;   ///< of a bootloader, "1-4.2"; "": the only one
  bool force = false;  ///< also while a run is under way
};

/// The machine's bootloaders. Tests have their own.
struct BootloaderCalls {
  std::function<std::vector<sync::FoundBootloader>()> find;
  std::function<void(std::string_view place, const sync::FlashImage& image,
                     const sync::FlashProgress& progress)>
      flash;
};
BootloaderCalls machine_bootloaders();

/// How long to wait for what the bus brings.
struct FlashWaits {
  std::chrono::milliseconds bootloader{10'000}, board{20'000}, permission{3'000}, look{100};
};

/// The one whom flash_board() asks and tells.
class FlashObserver {
 public:
  virtual ~FlashObserver() = default;
  /// Shall the board that runs this be flashed? Not asked where a bootloader waits already.
  virtual bool confirm(const sync::Info& board) = 0;
  /// What is going on, for a line that is rewritten.
  virtual void progress(const std::string& text) = 0;
};

/// What came of it.
struct FlashOutcome {
  std::optional<sync::Info> before;  ///< nothing: it waited in its bootloader
  sync::Info after;
};

/// Flashes the bootloader that waits, or else the board, which is asked into its bootloader first. Nothing if
/// `observer` does not confirm. Throws glint::Error, sync::Error: the file is not fit, no board, several, a
/// run is under way, and what the flasher says; each with what to do.
std::optional<FlashOutcome> flash_board(const FlashOptions& options, FlashObserver& observer,
                                        sync::HidBus& bus, const BootloaderCalls& bootloaders,
                                        const FlashWaits& waits = {});

}  // namespace glint::apps
