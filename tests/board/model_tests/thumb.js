// SPDX-License-Identifier: MIT
// A few Thumb instructions, enough for the small programs of these tests.

/** Collects instructions; place() puts them, with their constants behind, into the chip's memory. */
export class Thumb {
  constructor() {
    this.words = [];
    this.labels = new Map();
    this.fixes = []; // [index, (address of the instruction, memory of constants) => word]
    this.constants = [];
  }

  emit(...words) {
    this.words.push(...words);
    return this;
  }

  label(name) {
    this.labels.set(name, this.words.length);
    return this;
  }

  /** Any 32-bit constant. */
  load(register, value) {
    const slot = this.constants.length;
    this.constants.push(value >>> 0);
    this.fixes.push([this.words.length, (address, pool) =>
      0x4800 | (register << 8) | ((pool + 4 * slot - ((address + 4) & ~3)) >> 2)]);
    return this.emit(0);
  }

  branch(name) {
    this.fixes.push([this.words.length, (address, pool, start) =>
      0xe000 | (((start + 2 * this.labels.get(name) - address - 4) >> 1) & 0x7ff)]);
    return this.emit(0);
  }

  str(rt, rn, offset = 0) {
    return this.emit(0x6000 | ((offset >> 2) << 6) | (rn << 3) | rt);
  }

  ldr(rt, rn, offset = 0) {
    return this.emit(0x6800 | ((offset >> 2) << 6) | (rn << 3) | rt);
  }

  movs(rd, value) {
    return this.emit(0x2000 | (rd << 8) | value);
  }

  adds(rd, value) {
    return this.emit(0x3000 | (rd << 8) | value);
  }

  blx(register) {
    return this.emit(0x4780 | (register << 3));
  }

  nop(count = 1) {
    return this.emit(...new Array(count).fill(0xbf00));
  }

  wfi() {
    return this.emit(0xbf30);
  }

  cpsid() {
    return this.emit(0xb672);
  }

  cpsie() {
    return this.emit(0xb662);
  }

  bx_lr() {
    return this.emit(0x4770);
  }

  /** The bytes as they stand at that address. */
  bytes(start) {
    const words = [...this.words];
    if (words.length % 2) words.push(0xbf00);
    const pool = start + 2 * words.length;
    for (const [index, make] of this.fixes) words[index] = make(start + 2 * index, pool, start);
    return Uint8Array.from([...Uint8Array.from(words.flatMap((word) => [word & 255, word >> 8])),
      ...this.constants.flatMap((value) => [value & 255, (value >>> 8) & 255, (value >>> 16) & 255, value >>> 24])]);
  }

  /** Puts it into RAM; returns its address with the Thumb bit. */
  place(chip, address) {
    chip.sram.set(this.bytes(address), address - 0x20000000);
    return address | 1;
  }
}
