// SPDX-License-Identifier: MIT
// PICOBOOT, the USB protocol of the RP2040's boot ROM (RP2040 datasheet, 2.8.5).
#pragma once

#include <chrono>
#include <cstdint>
#include <span>

namespace glint::sync {

/// The transfers of the bootloader's vendor interface. Tests answer them with a chip of their own.
class PicobootPort {
 public:
  enum class Result : std::uint8_t { Done, Stalled, Gone, TimedOut };

  virtual ~PicobootPort() = default;
  /// All of `bytes`; an empty transfer if there are none.
  virtual Result send(std::span<const std::uint8_t> bytes) noexcept = 0;
  /// Exactly as many bytes as fit; an empty transfer if none do.
  virtual Result receive(std::span<std::uint8_t> bytes) noexcept = 0;
  /// PICOBOOT's INTERFACE RESET: ends stalls and whatever was under way.
  virtual Result reset_interface() noexcept = 0;
  /// PICOBOOT's GET COMMAND STATUS: 16 bytes.
  virtual Result command_status(std::span<std::uint8_t, 16> status) noexcept = 0;
};

/// The commands. Each throws Error with what was being done, where, and why it failed.
class Picoboot {
 public:
  static constexpr std::uint32_t kPageBytes = 256;
  static constexpr std::uint32_t kSectorBytes = 4096;

  explicit Picoboot(PicobootPort& port) noexcept : port_(&port) {}

  /// Begins from a known state, and keeps the drive's writes out.
  void take_exclusively();
  /// Makes the flash writable.
  void exit_xip();
  /// Address and size are multiples of kSectorBytes.
  void erase(std::uint32_t address, std::uint32_t bytes);
  /// Address is a multiple of kPageBytes.
  void write(std::uint32_t address, std::span<const std::uint8_t> bytes);
  void read(std::uint32_t address, std::span<std::uint8_t> into);
  /// Restarts from the flash after `delay`; the port is good for nothing afterwards.
  void reboot(std::chrono::milliseconds delay);

 private:
  struct Command;
  void run(const Command& command, std::span<const std::uint8_t> out, std::span<std::uint8_t> in);
  [[noreturn]] void fail(const Command& command, PicobootPort::Result result);

  PicobootPort* port_;
  std::uint32_t token_ = 0;
};

}  // namespace glint::sync
