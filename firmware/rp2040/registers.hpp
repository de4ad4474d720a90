// SPDX-License-Identifier: MIT
// The registers of the RP2040 that glint uses; names and addresses as in its datasheet (build-date
// 2023-06-14).
#pragma once

#include <stdint.h>

namespace glint::rp2040 {

/// One 32-bit register. Most peripherals (not SIO, not the processor's own) can change single bits by writing
/// to aliases of the address, which no interrupt can come between.
class Register {
 public:
  constexpr explicit Register(uint32_t address) : address_(address) {}
  uint32_t read() const { return *at(0); }
  void write(uint32_t value) const { *at(0) = value; }
  void flip(uint32_t bits) const { *at(0x1000) = bits; }
  void set(uint32_t bits) const { *at(0x2000) = bits; }
  void clear(uint32_t bits) const { *at(0x3000) = bits; }
  /// Writes the bits of `mask`, in two steps that others may see between.
  void write_field(uint32_t mask, uint32_t value) const { flip((read() ^ value) & mask); }

 private:
  volatile uint32_t* at(uint32_t alias) const {
    return reinterpret_cast<volatile uint32_t*>(static_cast<uintptr_t>(address_ + alias));
  }
  uint32_t address_;
};

constexpr uint32_t bit(unsigned n) { return uint32_t{1} << n; }

namespace resets {
inline constexpr Register kReset{0x4000c000}, kDone{0x4000c008};
inline constexpr uint32_t kAdc = bit(0), kIoBank0 = bit(5), kPadsBank0 = bit(8), kPio0 = bit(10),
                          kPio1 = bit(11), kPllSys = bit(12), kPllUsb = bit(13), kTimer = bit(21),
                          kUsb = bit(24);
}  // namespace resets

namespace clocks {
inline constexpr Register kRefControl{0x40008030}, kRefSelected{0x40008038}, kSysControl{0x4000803c},
    kSysSelected{0x40008044}, kUsbControl{0x40008054}, kAdcControl{0x40008060}, kResusControl{0x40008078};
inline constexpr uint32_t kEnable = bit(11);  // of USB and ADC; their auxiliary source 0 is PLL_USB
}  // namespace clocks

namespace xosc {
inline constexpr Register kControl{0x40024000}, kStatus{0x40024004}, kStartup{0x4002400c};
inline constexpr uint32_t kEnable1To15MHz = 0xfab000 | 0xaa0, kStable = bit(31);
}  // namespace xosc

struct Pll {
  Register control, power, feedback, dividers;
};
inline constexpr Pll kPllSys{Register{0x40028000}, Register{0x40028004}, Register{0x40028008},
                             Register{0x4002800c}};
inline constexpr Pll kPllUsb{Register{0x4002c000}, Register{0x4002c004}, Register{0x4002c008},
                             Register{0x4002c00c}};
namespace pll {
inline constexpr uint32_t kLocked = bit(31), kPowerDown = bit(0), kDividersDown = bit(3),
                          kOscillatorDown = bit(5);
}

namespace psm {
inline constexpr Register kWatchdogSelect{0x40010008};
inline constexpr uint32_t kAllButOscillators = 0x1fffc;
}  // namespace psm

namespace watchdog {
inline constexpr Register kControl{0x40058000}, kLoad{0x40058004}, kReason{0x40058008}, kTick{0x4005802c};
constexpr Register scratch(unsigned n) { return Register{0x4005800c + 4 * n}; }
inline constexpr uint32_t kEnable = bit(30), kTrigger = bit(31), kTickEnable = bit(9);
}  // namespace watchdog

namespace rosc {
inline constexpr Register kRandomBit{0x4006001c};
}

namespace timer {
inline constexpr Register kRawHigh{0x40054024}, kRawLow{0x40054028}, kAlarm0{0x40054010}, kArmed{0x40054020},
    kRaised{0x40054034}, kInterruptEnable{0x40054038};
}

namespace adc {
inline constexpr Register kControl{0x4004c000}, kFifoControl{0x4004c008}, kFifo{0x4004c00c},
    kDivider{0x4004c010}, kInterruptEnable{0x4004c018};
inline constexpr uint32_t kEnable = bit(0), kStartMany = bit(3), kReady = bit(8), kFifoEnable = bit(0),
                          kEmpty = bit(8);
constexpr uint32_t threshold(uint32_t samples) { return samples << 24; }
}  // namespace adc

namespace io {
constexpr Register status(unsigned pin) { return Register{0x40014000 + 8 * pin}; }
constexpr Register control(unsigned pin) { return Register{0x40014004 + 8 * pin}; }
/// Four bits for each pin, eight pins a register.
constexpr Register raised(unsigned pin) { return Register{0x400140f0 + pin / 8 * 4}; }
constexpr Register interrupt_enable(unsigned pin) { return Register{0x40014100 + pin / 8 * 4}; }
constexpr uint32_t edge_low(unsigned pin) { return bit(pin % 8 * 4 + 2); }
constexpr uint32_t edge_high(unsigned pin) { return bit(pin % 8 * 4 + 3); }

enum class Function : uint32_t { Sio = 5, Pio0 = 6, Pio1 = 7, None = 31 };
/// What reaches the pad, or the peripherals, instead of what drives it.
enum class Override : uint32_t { Normal = 0, Invert = 1, Low = 2, High = 3 };
inline constexpr uint32_t kOutShift = 8, kInShift = 16;
inline constexpr uint32_t kFromPad = bit(17);  // in status: the level before any override
inline void override_out(unsigned pin, Override how) {
  control(pin).write_field(3u << kOutShift, static_cast<uint32_t>(how) << kOutShift);
}
inline void override_in(unsigned pin, Override how) {
  control(pin).write_field(3u << kInShift, static_cast<uint32_t>(how) << kInShift);
}
}  // namespace io

namespace pads {
constexpr Register pin(unsigned n) { return Register{0x4001c004 + 4 * n}; }
inline constexpr uint32_t kSchmitt = bit(1), kPullDown = bit(2), kPullUp = bit(3), kDrive4mA = 1u << 4,
                          kInputEnable = bit(6), kOutputDisable = bit(7);
}  // namespace pads

namespace sio {
inline constexpr Register kIn{0xd0000004}, kOutSet{0xd0000014}, kOutClear{0xd0000018},
    kOutEnableSet{0xd0000024};
}

/// One of the two PIO blocks.
class Pio {
 public:
  constexpr explicit Pio(uint32_t base) : base_(base) {}
  constexpr Register control() const { return Register{base_}; }
  constexpr Register fifo_debug() const { return Register{base_ + 0x08}; }
  constexpr Register fifo_levels() const { return Register{base_ + 0x0c}; }
  constexpr Register transmit(unsigned sm) const { return Register{base_ + 0x10 + 4 * sm}; }
  constexpr Register receive(unsigned sm) const { return Register{base_ + 0x20 + 4 * sm}; }
  constexpr Register instruction_memory(unsigned n) const { return Register{base_ + 0x48 + 4 * n}; }
  constexpr Register clock_divider(unsigned sm) const { return Register{base_ + 0xc8 + 0x18 * sm}; }
  constexpr Register execute_control(unsigned sm) const { return Register{base_ + 0xcc + 0x18 * sm}; }
  constexpr Register shift_control(unsigned sm) const { return Register{base_ + 0xd0 + 0x18 * sm}; }
  constexpr Register address(unsigned sm) const { return Register{base_ + 0xd4 + 0x18 * sm}; }
  constexpr Register execute(unsigned sm) const { return Register{base_ + 0xd8 + 0x18 * sm}; }
  constexpr Register pin_control(unsigned sm) const { return Register{base_ + 0xdc + 0x18 * sm}; }

 private:
  uint32_t base_;
};
inline constexpr Pio kPio[2] = {Pio{0x50200000}, Pio{0x50300000}};

namespace usb {
inline constexpr uint32_t kMemory = 0x50100000;
inline constexpr Register kAddress{0x50110000}, kMainControl{0x50110040}, kSieControl{0x5011004c},
    kSieStatus{0x50110050}, kBufferStatus{0x50110058}, kStallArm{0x50110068}, kMuxing{0x50110074},
    kPower{0x50110078}, kInterruptEnable{0x50110090}, kInterrupts{0x50110098};
inline constexpr uint32_t kControllerEnable = bit(0), kPullUp = bit(16), kInterruptPerBuffer = bit(29);
inline constexpr uint32_t kStatusSuspended = bit(4), kStatusSetup = bit(17), kStatusBusReset = bit(19);
inline constexpr uint32_t kToPhy = bit(0), kSoftConnect = bit(3), kVbusDetect = bit(2),
                          kVbusOverride = bit(3);
inline constexpr uint32_t kBufferInterrupt = bit(4), kBusResetInterrupt = bit(12),
                          kSuspendInterrupt = bit(14), kSetupInterrupt = bit(16);
inline constexpr Register kEp1InControl{kMemory + 0x08};
inline constexpr Register kEp0InBuffer{kMemory + 0x80}, kEp0OutBuffer{kMemory + 0x84},
    kEp1InBuffer{kMemory + 0x88};
inline constexpr uint32_t kEp0Data = kMemory + 0x100, kEp1Offset = 0x180, kEp1Data = kMemory + kEp1Offset;
inline constexpr uint32_t kFull = bit(15), kLast = bit(14), kData1 = bit(13), kStall = bit(11),
                          kAvailable = bit(10), kLengthMask = 0x3ff;
inline constexpr uint32_t kEndpointEnable = bit(31), kEndpointPerBuffer = bit(29),
                          kEndpointInterrupt = 3u << 26;
}  // namespace usb

namespace ssi {
inline constexpr Register kControl0{0x18000000}, kEnable{0x18000008}, kSlave{0x18000010}, kBaud{0x18000014},
    kReceiveLevel{0x18000024}, kData{0x18000060};
}
inline constexpr Register kFlashSelectControl{0x4001800c};

namespace cortex {
inline constexpr Register kSysTickControl{0xe000e010}, kSysTickReload{0xe000e014}, kSysTickValue{0xe000e018},
    kInterruptSet{0xe000e100}, kPend{0xe000e200};
constexpr Register priority(unsigned irq) { return Register{0xe000e400 + irq / 4 * 4}; }
}  // namespace cortex

enum Irq : unsigned { kIrqTimer0 = 0, kIrqUsb = 5, kIrqIoBank0 = 13, kIrqAdc = 22, kIrqEdge = 26 };

}  // namespace glint::rp2040
