// SPDX-License-Identifier: MIT
// The chip from reset to a running clock, and what it can tell of itself.
#pragma once

#include <stdint.h>

namespace glint::rp2040 {

/// Crystal, 125 MHz for the processor, 48 MHz for USB and ADC, a timer that counts microseconds; peripherals
/// out of reset.
void start_clocks();

/// Serial number of the flash chip. Only while nothing is read from the flash.
void read_flash_serial(uint8_t (&serial)[8]);

/// From the ring oscillator's noise.
uint32_t random_bits();

/// Why the chip was reset, and a number that differs from all that this call gave since power-up. To be
/// called once.
struct Boot {
  uint8_t reason;  ///< glint_sync_reset
  uint32_t epoch;
};
Boot take_boot();

/// Resets the chip, as if by the watchdog; tells the next take_boot() that it was wanted.
[[noreturn]] void reset_chip();
/// Leaves glint for the bootloader in ROM.
[[noreturn]] void start_bootloader();

/// The chip is reset when nobody has called feed_watchdog() for that long.
void start_watchdog(uint32_t timeout_us);
void feed_watchdog();

}  // namespace glint::rp2040
