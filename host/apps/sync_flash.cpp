// SPDX-License-Identifier: MIT
// Boards and bootloaders that come and go on the bus.
#include "host/apps/sync_flash.hpp"

#include <algorithm>
#include <cmath>
#include <thread>

#include "host/apps/sync_text.hpp"
#include "host/base/error.hpp"
#include "usb-sync/board_text.hpp"
#include "usb-sync/error.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint::apps {
namespace {

constexpr const char* kByHand =
    "hold BOOTSEL while plugging the board in, then run this again (or copy the file onto the drive that "
    "appears)";

using Places = std::vector<std::string>;

Places places_of(const BootloaderCalls& bootloaders) {
  Places places;
  for (const sync::FoundBootloader& found : bootloaders.find()) places.push_back(found.place);
  return places;
}

bool contains(const std::vector<std::string>& list, const std::string& text) {
  return std::find(list.begin(), list.end(), text) != list.end();
}

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// Calls `look` until it gives something; nothing if that takes longer.
template <class Look>
auto wait_for(std::chrono::milliseconds longest, std::chrono::milliseconds pause, Look&& look)
    -> decltype(look()) {
  const sync::HostTime deadline = sync::HostClock::now() + longest;
  while (true) {
    if (auto found = look()) return found;
    if (sync::HostClock::now() >= deadline) return std::nullopt;
    std::this_thread::sleep_for(pause);
  }
}

/// A board that is to go into its bootloader: open, and at rest. `places`: of the bootloaders that wait.
sync::SyncBoard open_for_flashing(const FlashOptions& options, sync::HidBus& bus, const Places& places) {
  std::optional<sync::SyncBoard> board;
  try {
    board.emplace(sync::SyncBoard::open(options.serial, bus));
  } catch (const sync::NoBoard& error) {
    if (!places.empty()) {
      throw Error(std::string(error.what()) + "; but one waits in its bootloader at " + joined(places) +
                  ": leave out --board to flash that");
    }
    if (!options.serial.empty()) throw;
    throw Error(std::string("no sync board is plugged in, neither running nor in its bootloader: ") +
                kByHand);
  } catch (const sync::Error& error) {  // it speaks another protocol, for one
    throw Error(std::string(error.what()) +
                "; a board that cannot be talked to can be flashed all the same: " + kByHand);
  }
  const sync::Status status = board->status();
  if (status.state != sync::RunState::Idle && !options.force) {
    throw Error("sync board " + board->info().serial + " is " + sync::state_text(status.state) +
                ": stop it first (glint sync stop), or add --force");
  }
  return std::move(*board);
}

/// Makes the board leave for its bootloader; where that has come.
std::string enter_bootloader(sync::SyncBoard& board, const BootloaderCalls& bootloaders,
                             const FlashWaits& waits) {
  const Places before = places_of(bootloaders);
  board.enter_bootloader();
  const auto place = wait_for(waits.bootloader, waits.look, [&]() -> std::optional<std::string> {
    for (std::string& here : places_of(bootloaders)) {
      if (!contains(before, here)) return std::move(here);
    }
    return std::nullopt;
  });
  if (place) return *place;
  throw Error("sync board " + board.info().serial + " did not come up in its bootloader: " + kByHand);
}

std::string percent_text(sync::FlashStep step, double share) {
  return std::string(sync::step_text(step)) + format_text(" %.0f %%", std::floor(share * 100.0));
}

/// udev may need a moment before it gives permission to what has just appeared.
void flash_at(const std::string& place, const sync::FlashImage& image, FlashObserver& observer,
              const BootloaderCalls& bootloaders, const FlashWaits& waits) {
  const sync::HostTime deadline = sync::HostClock::now() + waits.permission;
  bool begun = false;
  std::string shown;
  const auto show = [&](sync::FlashStep step, double share) {
    begun = true;
    const std::string text = percent_text(step, share);
    if (text != shown) observer.progress(text);
    shown = text;
  };
  while (true) {
    try {
      bootloaders.flash(place, image, show);
      return;
    } catch (const sync::Error&) {
      if (begun || sync::HostClock::now() >= deadline) throw;
    }
    std::this_thread::sleep_for(waits.look);
  }
}

std::vector<std::string> serials_on(sync::HidBus& bus) {
  std::vector<std::string> serials;
  for (const sync::FoundBoard& found : sync::find_boards(bus)) serials.push_back(found.serial);
  return serials;
}

/// The board that is to come back: with that serial number, or, where it is not known, a new one.
sync::Info wait_for_board(const std::string& serial, const std::vector<std::string>& others,
                          const FlashOptions& options, sync::HidBus& bus, const FlashWaits& waits) {
  std::string trouble;
  const auto info = wait_for(waits.board, waits.look, [&]() -> std::optional<sync::Info> {
    for (const std::string& found : serials_on(bus)) {
      const bool wanted = serial.empty() ? !contains(others, found) : found == serial;
      if (!wanted) continue;
      try {
        return sync::SyncBoard::open(found, bus).info();
      } catch (const sync::Error& error) {
        trouble = error.what();
      }
    }
    return std::nullopt;
  });
  if (info) return *info;
  const std::string written = options.file + " was written and read back rightly, but ";
  if (!trouble.empty()) throw Error(written + "the board cannot be used: " + trouble);
  throw Error(written +
              "no sync board has come up with it: is it the sync board's firmware? To write another file, " +
              kByHand);
}

}  // namespace

BootloaderCalls machine_bootloaders() {
  return {sync::find_bootloaders,
          [](std::string_view place, const sync::FlashImage& image, const sync::FlashProgress& progress) {
            const auto port = sync::open_bootloader(place);
            sync::flash(*port, image, progress);
          }};
}

std::optional<FlashOutcome> flash_board(const FlashOptions& options, FlashObserver& observer,
                                        sync::HidBus& bus, const BootloaderCalls& bootloaders,
                                        const FlashWaits& waits) {
  const sync::FlashImage image = sync::read_uf2(options.file);
  const std::vector<std::string> serials = serials_on(bus);
  const Places places = places_of(bootloaders);
  const bool wants_bootloader = !options.place.empty() || (!places.empty() && options.serial.empty());
  if (wants_bootloader && options.place.empty() && !serials.empty()) {
    throw Error("a board waits in its bootloader at " + joined(places) + ", and sync board " +
                joined(serials) + " is plugged in: say which to flash, --place " + places.front() +
                " or --board " + serials.front());
  }

  FlashOutcome outcome;
  std::string place = options.place;
  if (!wants_bootloader) {
    sync::SyncBoard board = open_for_flashing(options, bus, places);
    outcome.before = board.info();
    if (!observer.confirm(*outcome.before)) return std::nullopt;
    observer.progress("waiting for the bootloader");
    place = enter_bootloader(board, bootloaders, waits);
  }
  flash_at(place, image, observer, bootloaders, waits);
  observer.progress("waiting for the board");
  outcome.after = wait_for_board(outcome.before ? outcome.before->serial : "", serials, options, bus, waits);
  return outcome;
}

}  // namespace glint::apps
