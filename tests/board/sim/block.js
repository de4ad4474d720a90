// SPDX-License-Identifier: MIT
// A block of registers on the bus: the four aliases of RP2040 (plain, XOR, SET, CLEAR), and the reset gate before it.

/** Base of our own peripherals: subclasses give read(offset) and write(offset, value). In write(), `raw` holds the bits
 * as written, which is what write-1-to-clear registers look at, whichever alias was used. */
export class Block {
  constructor(chip, name) {
    this.chip = chip;
    this.name = name;
    this.raw = 0;
  }

  readUint32(offset) {
    return this.read(offset & 0xfff) >>> 0;
  }

  writeUint32Atomic(offset, value, alias) {
    this.raw = value >>> 0;
    let word = this.raw;
    if (alias !== 0) {
      const old = this.read(offset) >>> 0;
      word = (alias === 1 ? old ^ word : alias === 2 ? old | word : old & ~word) >>> 0;
    }
    this.write(offset, word);
  }

  writeUint32(offset, value) {
    this.writeUint32Atomic(offset, value, 0);
  }

  unknown(what, offset) {
    this.chip.complain(`${this.name}: ${what} of register 0x${offset.toString(16)}, which the model does not have`);
    return 0;
  }
}

/** What RESETS holds in reset reads as 0 and ignores writes. */
export class Gate {
  constructor(chip, inner, bit, name) {
    this.chip = chip;
    this.inner = inner;
    this.bit = bit;
    this.name = name;
  }

  get in_reset() {
    return ((this.chip.resets.held >>> this.bit) & 1) !== 0;
  }

  readUint32(offset) {
    if (!this.in_reset) return this.inner.readUint32(offset);
    this.chip.complain(`${this.name} is read while RESETS holds it in reset`);
    return 0;
  }

  writeUint32Atomic(offset, value, alias) {
    if (!this.in_reset) this.inner.writeUint32Atomic(offset, value, alias);
    else this.chip.complain(`${this.name} is written while RESETS holds it in reset`);
  }
}
