// SPDX-License-Identifier: MIT
#include "firmware/rp2040/chip.hpp"

#include "firmware/protocol/sync_report.h"
#include "firmware/rp2040/registers.hpp"

namespace glint::rp2040 {
namespace {

constexpr uint32_t kCrystal_mhz = 12;

void wait_for(const Register& reg, uint32_t bits) {
  while ((reg.read() & bits) != bits) {
  }
}

void start_pll(const Pll& pll, uint32_t reset, uint32_t feedback, uint32_t divider1, uint32_t divider2) {
  resets::kReset.set(reset);
  resets::kReset.clear(reset);
  wait_for(resets::kDone, reset);
  pll.control.write(1);  // reference: the crystal, undivided
  pll.feedback.write(feedback);
  pll.power.clear(pll::kPowerDown | pll::kOscillatorDown);
  wait_for(pll.control, pll::kLocked);
  pll.dividers.write(divider1 << 16 | divider2 << 12);
  pll.power.clear(pll::kDividersDown);
}

// Scratch registers outlive resets by the watchdog, but not the loss of power. The ROM uses 4 to 7.
constexpr Register kMark = watchdog::scratch(0), kLastEpoch = watchdog::scratch(1),
                   kWanted = watchdog::scratch(2);
constexpr uint32_t kMarkValue = 0x676c6e74;

uint32_t g_watchdog_load;

}  // namespace

void start_clocks() {
  clocks::kResusControl.write(0);
  xosc::kControl.write(0xaa0);
  // 64 times the datasheet's millisecond: some boards' crystals are slow.
  xosc::kStartup.write((kCrystal_mhz * 1000 + 128) / 256 * 64);
  xosc::kControl.write(xosc::kEnable1To15MHz);
  wait_for(xosc::kStatus, xosc::kStable);
  // Off the PLLs while they start.
  clocks::kSysControl.clear(1);
  wait_for(clocks::kSysSelected, 1);
  clocks::kRefControl.clear(3);
  wait_for(clocks::kRefSelected, 1);
  start_pll(kPllSys, resets::kPllSys, 125, 6, 2);  // 1500 MHz / 12
  start_pll(kPllUsb, resets::kPllUsb, 100, 5, 5);  // 1200 MHz / 25
  clocks::kRefControl.write(2);                    // crystal
  wait_for(clocks::kRefSelected, bit(2));
  clocks::kSysControl.write(0);  // auxiliary source: PLL_SYS
  clocks::kSysControl.set(1);
  wait_for(clocks::kSysSelected, bit(1));
  clocks::kUsbControl.write(clocks::kEnable);
  clocks::kAdcControl.write(clocks::kEnable);
  watchdog::kTick.write(kCrystal_mhz | watchdog::kTickEnable);
  constexpr uint32_t kUsed = resets::kAdc | resets::kIoBank0 | resets::kPadsBank0 | resets::kPio0 |
                             resets::kPio1 | resets::kTimer | resets::kUsb;
  resets::kReset.set(kUsed);
  resets::kReset.clear(kUsed);
  wait_for(resets::kDone, kUsed);
}

void read_flash_serial(uint8_t (&serial)[8]) {
  constexpr uint8_t kReadUniqueId = 0x4b;
  constexpr unsigned kDummies = 4, kBytes = 1 + kDummies + sizeof serial;
  ssi::kEnable.write(0);
  ssi::kBaud.write(8);
  ssi::kControl0.write(7u << 16);  // 8-bit words, both ways
  ssi::kEnable.write(1);
  ssi::kSlave.write(1);
  constexpr uint32_t kLow = 2u << 8, kHigh = 3u << 8;
  kFlashSelectControl.write_field(kHigh, kLow);
  unsigned sent = 0, received = 0;
  while (received < kBytes) {
    if (sent < kBytes && sent - received < 8) ssi::kData.write(sent++ == 0 ? kReadUniqueId : 0);
    if (ssi::kReceiveLevel.read() == 0) continue;
    const uint32_t byte = ssi::kData.read();
    if (received > kDummies) serial[received - kDummies - 1] = static_cast<uint8_t>(byte);
    ++received;
  }
  kFlashSelectControl.write_field(kHigh, kHigh);
  ssi::kEnable.write(0);
}

uint32_t random_bits() {
  // Mixed, as neighbouring bits of the oscillator hang together.
  uint32_t bits = 0;
  for (int i = 0; i < 256; ++i) bits = (bits << 5 | bits >> 27) ^ (rosc::kRandomBit.read() & 1);
  return bits;
}

Boot take_boot() {
  const bool marked = kMark.read() == kMarkValue;
  Boot boot{GLINT_SYNC_RESET_POWER, random_bits()};
  if (marked && boot.epoch == kLastEpoch.read()) ++boot.epoch;
  if (marked && watchdog::kReason.read() != 0)
    boot.reason = kWanted.read() == kMarkValue ? GLINT_SYNC_RESET_COMMAND : GLINT_SYNC_RESET_WATCHDOG;
  kMark.write(kMarkValue);
  kLastEpoch.write(boot.epoch);
  kWanted.write(0);
  return boot;
}

void start_watchdog(uint32_t timeout_us) {
  watchdog::kControl.clear(watchdog::kEnable);
  psm::kWatchdogSelect.set(psm::kAllButOscillators);
  g_watchdog_load = timeout_us * 2;  // it counts twice a microsecond: erratum RP2040-E1
  watchdog::kLoad.write(g_watchdog_load);
  watchdog::kControl.set(watchdog::kEnable);
}

void feed_watchdog() { watchdog::kLoad.write(g_watchdog_load); }

void reset_chip() {
  kWanted.write(kMarkValue);
  psm::kWatchdogSelect.set(psm::kAllButOscillators);
  watchdog::kControl.set(watchdog::kTrigger);
  for (;;) {
  }
}

void start_bootloader() {
  kWanted.write(kMarkValue);  // the ROM leaves by the watchdog, too
  watchdog::kControl.clear(watchdog::kEnable);
  // Where the ROM keeps its functions: datasheet, section 2.8.3.
  using Lookup = void* (*)(const uint16_t*, uint32_t);
  using ResetToUsb = void (*)(uint32_t led_mask, uint32_t disabled_interfaces);
  const auto half = [](uintptr_t address) { return *reinterpret_cast<volatile const uint16_t*>(address); };
  const auto lookup = reinterpret_cast<Lookup>(static_cast<uintptr_t>(half(0x18)));
  const auto* table = reinterpret_cast<const uint16_t*>(static_cast<uintptr_t>(half(0x14)));
  const auto reset_to_usb = reinterpret_cast<ResetToUsb>(lookup(table, 'U' | 'B' << 8));
  reset_to_usb(0, 0);
  for (;;) {
  }
}

}  // namespace glint::rp2040
