// SPDX-License-Identifier: MIT
#include "usb-sync/picoboot.hpp"

#include <array>
#include <cstring>
#include <string>

#include "usb-sync/error.hpp"

namespace glint::sync {
namespace {

constexpr std::uint32_t kMagic = 0x431fd10b;

// Commands; those that send data to the host have bit 7 set.
constexpr std::uint8_t kExclusive = 0x01, kReboot = 0x02, kErase = 0x03, kWrite = 0x05, kExitXip = 0x06,
                       kRead = 0x84;

/// What GET COMMAND STATUS says.
const char* status_text(std::uint32_t status) noexcept {
  switch (status) {
    case 1:
      return "unknown command";
    case 2:
      return "wrong length of the command";
    case 3:
      return "wrong length of the data";
    case 4:
      return "address outside of what may be touched";
    case 5:
      return "address not aligned";
    case 6:
      return "the drive was written to meanwhile";
    case 7:
      return "it is restarting";
    default:
      return "it does not say why";
  }
}

}  // namespace

struct Picoboot::Command {
  std::uint8_t id;
  std::uint8_t argument_bytes;
  std::array<std::uint32_t, 4> arguments;
  const char* what;  // to people: "erasing"
};

void Picoboot::take_exclusively() {
  constexpr std::uint32_t kDriveIsReadOnly = 1;
  const Command command{kExclusive, 1, {kDriveIsReadOnly}, "taking over the bootloader"};
  if (const auto result = port_->reset_interface(); result != PicobootPort::Result::Done)
    fail(command, result);
  run(command, {}, {});
}

void Picoboot::exit_xip() { run({kExitXip, 0, {}, "making the flash writable"}, {}, {}); }

void Picoboot::erase(std::uint32_t address, std::uint32_t bytes) {
  run({kErase, 8, {address, bytes}, "erasing"}, {}, {});
}

void Picoboot::write(std::uint32_t address, std::span<const std::uint8_t> bytes) {
  run({kWrite, 8, {address, static_cast<std::uint32_t>(bytes.size())}, "writing"}, bytes, {});
}

void Picoboot::read(std::uint32_t address, std::span<std::uint8_t> into) {
  run({kRead, 8, {address, static_cast<std::uint32_t>(into.size())}, "reading back"}, {}, into);
}

void Picoboot::reboot(std::chrono::milliseconds delay) {
  constexpr std::uint32_t kFromFlash = 0;
  run({kReboot, 12, {kFromFlash, 0, static_cast<std::uint32_t>(delay.count())}, "restarting"}, {}, {});
}

/// A command, its data, and an empty transfer the other way that ends it.
void Picoboot::run(const Command& command, std::span<const std::uint8_t> out, std::span<std::uint8_t> in) {
  std::array<std::uint8_t, 32> wire{};
  const std::uint32_t length = static_cast<std::uint32_t>(out.size() + in.size());
  ++token_;
  std::memcpy(&wire[0], &kMagic, 4);
  std::memcpy(&wire[4], &token_, 4);
  wire[8] = command.id;
  wire[9] = command.argument_bytes;
  std::memcpy(&wire[12], &length, 4);
  std::memcpy(&wire[16], command.arguments.data(), sizeof command.arguments);

  auto result = port_->send(wire);
  if (result == PicobootPort::Result::Done && !out.empty()) result = port_->send(out);
  if (result == PicobootPort::Result::Done && !in.empty()) result = port_->receive(in);
  if (result == PicobootPort::Result::Done) result = in.empty() ? port_->receive({}) : port_->send({});
  if (result != PicobootPort::Result::Done) fail(command, result);
}

void Picoboot::fail(const Command& command, PicobootPort::Result result) {
  std::string text = command.what;
  if (command.argument_bytes == 8) {
    text += " " + std::to_string(command.arguments[1]) + " bytes at flash offset " +
            std::to_string(command.arguments[0] & 0x00ffffffu);
  }
  switch (result) {
    case PicobootPort::Result::Gone:
      throw Error(text + ": the board was unplugged; hold BOOTSEL while plugging it in, and flash again");
    case PicobootPort::Result::TimedOut:
      throw Error(text +
                  ": the bootloader does not answer; hold BOOTSEL while plugging it in, and flash again");
    case PicobootPort::Result::Stalled:
    case PicobootPort::Result::Done:
      break;
  }
  std::array<std::uint8_t, 16> status{};
  std::uint32_t code = 0;
  if (port_->command_status(status) == PicobootPort::Result::Done) std::memcpy(&code, &status[4], 4);
  throw Error(text + ": refused by the bootloader (" + status_text(code) + ")");
}

}  // namespace glint::sync
