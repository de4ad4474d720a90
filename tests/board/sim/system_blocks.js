// SPDX-License-Identifier: MIT
// Small blocks: RESETS, PLLs, ring oscillator with its random bit, voltage regulator, identity.
import { Block } from "./block.js";

const RESET_BITS = 0x01ffffff;
const HELD_BY_ROM = RESET_BITS & ~((1 << 6) | (1 << 9)); // the ROM needs IO_QSPI and PADS_QSPI only

/** Peripherals start in reset, and what is put back into reset really forgets. */
export class Resets extends Block {
  constructor(chip) {
    super(chip, "RESETS");
    this.held = HELD_BY_ROM;
    this.watchdog_select = 0;
    this.gates = new Map(); // bit -> function that resets the peripheral
  }

  read(offset) {
    switch (offset) {
      case 0x0: return this.held;
      case 0x4: return this.watchdog_select;
      case 0x8: return ~this.held & RESET_BITS;
      default: return this.unknown("read", offset);
    }
  }

  write(offset, value) {
    if (offset === 0x4) {
      this.watchdog_select = value & RESET_BITS;
    } else if (offset === 0x0) {
      const newly_held = value & ~this.held & RESET_BITS;
      this.held = value & RESET_BITS;
      for (const [bit, reset] of this.gates) if (newly_held & (1 << bit)) reset();
    } else {
      this.unknown("write", offset);
    }
  }
}

/** rp2040js' PLL, except for its lock: it locks when powered and fed, some time after. */
export class Pll extends Block {
  constructor(chip, stock, name) {
    super(chip, name);
    this.stock = stock; // keeps the registers and works out the frequency
    this.locked_at = Infinity;
  }

  reset() {
    for (const [offset, value] of [[0, 1], [4, 0x2d], [8, 0], [12, 0x77000]]) this.stock.writeUint32(offset, value);
    this.locked_at = Infinity;
  }

  get powered() {
    return (this.stock.pwr & 0x21) === 0 && this.stock.fbdiv >= 16; // PD and VCOPD
  }

  read(offset) {
    const word = this.stock.readUint32(offset);
    if (offset !== 0) return word;
    return this.chip.queue.now >= this.locked_at ? word | (1 << 31) : word & 0x7fffffff;
  }

  write(offset, value) {
    const was_powered = this.powered;
    this.stock.writeUint32(offset, value);
    if (!this.powered) this.locked_at = Infinity;
    else if (!was_powered) this.locked_at = this.chip.queue.now + 5000; // 40 us
  }
}

/** ROSC: its random bit comes of a generator that the test seeds (xorshift, Marsaglia 2003). */
export class RingOscillator extends Block {
  constructor(chip, seed) {
    super(chip, "ROSC");
    this.state = seed >>> 0 || 1;
    this.registers = new Map([[0x00, 0xaa0], [0x10, 0x10]]);
  }

  random_bit() {
    let x = this.state;
    x ^= x << 13;
    x ^= x >>> 17;
    x ^= x << 5;
    this.state = x >>> 0;
    return (this.state >>> 16) & 1;
  }

  read(offset) {
    if (offset === 0x18) return 0x80001000; // stable, enabled
    if (offset === 0x1c) return this.random_bit();
    return this.registers.get(offset) ?? 0;
  }

  write(offset, value) {
    this.registers.set(offset, value);
  }
}

/** VREG_AND_CHIP_RESET: regulated; CHIP_RESET says why the chip started. */
export class Regulator extends Block {
  constructor(chip, cause) {
    super(chip, "VREG_AND_CHIP_RESET");
    this.registers = new Map([[0x0, 0xb1], [0x4, 0x91], [0x8, cause === "power" ? 1 << 8 : 0]]);
  }

  read(offset) {
    const word = this.registers.get(offset) ?? 0;
    return offset === 0 ? word | (1 << 12) : word;
  }

  write(offset, value) {
    if (offset < 8) this.registers.set(offset, value);
    else if (this.raw & (1 << 24)) this.registers.set(8, this.registers.get(8) & ~(1 << 24));
  }
}
