// SPDX-License-Identifier: MIT
// Opens each board for a moment.
#include "host/apps/sync_board_list.hpp"

#include <optional>

#include "host/apps/sync_json.hpp"
#include "host/apps/sync_text.hpp"
#include "usb-sync/board_text.hpp"
#include "usb-sync/error.hpp"
#include "usb-sync/flasher.hpp"
#include "usb-sync/sync_board.hpp"

namespace glint::apps {
namespace {

/// What a board says, or why it says nothing.
struct Answer {
  sync::FoundBoard found;
  std::optional<sync::Info> info;
  sync::Status status;
  std::string problem;

  /// "E66... at /dev/hidraw3".
  std::string name() const { return found.serial + (found.serial.empty() ? "" : " at ") + found.path; }
};

Answer ask(sync::HidBus& bus, const sync::FoundBoard& found) {
  Answer answer;
  answer.found = found;
  try {
    sync::SyncBoard board(bus.open(found));
    answer.status = board.status();
    answer.info = board.info();
  } catch (const sync::Error& error) {
    answer.problem = error.what();
  }
  return answer;
}

std::string versions_text(const sync::Info& info) {
  return format_text("firmware %s (%s), protocol %d.%d", info.firmware_text().c_str(), info.build.c_str(),
                     info.protocol_major, info.protocol_minor);
}

Finding finding_of(const Answer& answer, const std::string& version) {
  const char* check = "sync board";
  if (!answer.info) return {check, Verdict::Warning, answer.name() + ": " + answer.problem, ""};
  const std::string text = answer.name() + ": " + versions_text(*answer.info);
  if (answer.status.fault != 0) {
    return {check, Verdict::Warning, text + "; fault: " + sync::fault_text(answer.status.fault),
            "remove the cause, then glint sync clear"};
  }
  if (answer.status.after_watchdog) {
    return {check, Verdict::Warning, text + "; its firmware had hung, and its watchdog has reset it",
            "please report how that came about"};
  }
  if (answer.status.supply_locked) {
    return {check, Verdict::Warning,
            text + format_text("; the supply of the lights is too high, %.2f V, and strobes are locked out",
                               answer.status.supply_v),
            "lower it below 13.8 V"};
  }
  if (answer.info->firmware_text() == version) return {check, Verdict::Ok, text, ""};
  return {
      check, Verdict::Ok, text,
      "this program came with firmware " + version + ": glint sync flash FILE.uf2 puts it onto the board"};
}

}  // namespace

std::string sync_boards_text(sync::HidBus& bus) {
  std::string text;
  for (const sync::FoundBoard& found : bus.boards()) {
    const Answer answer = ask(bus, found);
    text += answer.name() + "  " +
            (answer.info ? versions_text(*answer.info) + ", " + sync::state_text(answer.status.state)
                         : answer.problem) +
            "\n";
  }
  return text;
}

void add_sync_boards(nlohmann::ordered_json& json, sync::HidBus& bus) {
  json["sync_boards"] = nlohmann::ordered_json::array();
  for (const sync::FoundBoard& found : bus.boards()) {
    const Answer answer = ask(bus, found);
    nlohmann::ordered_json one{{"path", found.path}, {"serial", found.serial}, {"problem", answer.problem}};
    if (answer.info) {
      one["info"] = info_json(*answer.info);
      one["status"] = status_json(answer.status);
    }
    json["sync_boards"].push_back(std::move(one));
  }
}

Findings check_sync_boards(sync::HidBus& bus, const std::vector<std::string>& bootloaders,
                           const std::string& version) {
  Findings findings;
  for (const sync::FoundBoard& found : bus.boards()) findings.push_back(finding_of(ask(bus, found), version));
  for (const std::string& place : bootloaders) {
    findings.push_back({"sync board", Verdict::Warning, "an RP2040 waits in its bootloader at " + place,
                        "if it is to be a sync board: glint sync flash FILE.uf2"});
  }
  return findings;
}

Findings check_sync_boards(const std::string& version) {
  std::vector<std::string> places;
  try {
    for (const sync::FoundBootloader& found : sync::find_bootloaders()) places.push_back(found.place);
  } catch (const sync::Error&) {  // no USB at all: then there is no board either
  }
  return check_sync_boards(sync::machine_hid_bus(), places, version);
}

}  // namespace glint::apps
