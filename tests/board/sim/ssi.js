// SPDX-License-Identifier: MIT
// The serial flash and the SSI in front of it: execute in place, and commands byte by byte (read, identity).
import { Block } from "./block.js";

const FLASH_BYTES = 2 * 1024 * 1024; // Raspberry Pi Pico: W25Q16JV
const FIFO_DEPTH = 16;

/** The flash chip as a clocked stream: a byte in, a byte out. Bytes survive everything but erasing. */
export class Flash {
  constructor(unique_id) {
    this.bytes = new Uint8Array(FLASH_BYTES).fill(0xff);
    this.words = new Uint32Array(this.bytes.buffer);
    this.unique_id = unique_id;
    this.command = [];
  }

  load(image, offset = 0) {
    this.bytes.set(image, offset);
  }

  /** Chip select has risen: the next byte is a command. */
  deselect() {
    this.command = [];
  }

  /** Undefined: a command that this flash does not have here. */
  exchange(byte) {
    const position = this.command.length;
    if (position < 8) this.command.push(byte);
    else this.command.length = position + 1;
    const [command, high, middle, low] = this.command;
    const address = ((high << 16) | (middle << 8) | low) % FLASH_BYTES;
    switch (command) {
      case 0x03: return position < 4 ? 0 : this.bytes[(address + position - 4) % FLASH_BYTES];
      case 0x0b: return position < 5 ? 0 : this.bytes[(address + position - 5) % FLASH_BYTES];
      case 0x4b: return position < 5 ? 0 : this.unique_id[(position - 5) % 8];
      case 0x9f: return [0, 0xef, 0x40, 0x15][Math.min(position, 3)];
      case 0x05: case 0x35: case 0x15: return 0; // status: not busy
      case 0x04: case 0x06: case 0x66: case 0x99: case 0xab: case 0xff: return 0;
      default: return undefined;
    }
  }
}

export class Ssi extends Block {
  constructor(chip, flash) {
    super(chip, "SSI");
    this.flash = flash;
    this.registers = new Map([[0x14, 0]]);
    this.enabled = true;
    this.rx = []; // { value, cycle from which it can be read }
    this.busy_until = 0;
    this.selected_by_force = false;
    this.set_execute_in_place();
  }

  // ---- execute in place

  /** As boot2 leaves it: command 03h, 24 address bits, EEPROM-read mode, 32 bits a word. */
  set_execute_in_place() {
    this.registers.set(0x00, 0x001f0300).set(0x04, 0).set(0xf4, 0x03000218).set(0x10, 1);
    this.enabled = true;
  }

  /** As ROM's flash_exit_xip: plain bytes. */
  set_serial() {
    this.registers.set(0x00, 0x00070000).set(0x14, 6).set(0x10, 1);
    this.enabled = true;
  }

  get executes_in_place() {
    return this.enabled && ((this.registers.get(0) >>> 8) & 3) === 3 && ((this.registers.get(0) >>> 16) & 31) === 31;
  }

  read_flash(offset) {
    if (!this.executes_in_place) this.chip.complain("flash is read at 0x10000000 while the SSI is not set up for it");
    return this.flash.words[(offset % FLASH_BYTES) >>> 2];
  }

  // ---- byte by byte

  /** IO_QSPI forces chip select low, or lets the SSI do it. */
  force_select(forced) {
    if (forced !== this.selected_by_force) this.flash.deselect();
    this.selected_by_force = forced;
  }

  transfer(value) {
    const { now } = this.chip.queue;
    if (!this.enabled || !(this.registers.get(0x10) & 1)) return;
    const bits = ((this.registers.get(0) >>> 16) & 31) + 1;
    if (bits !== 8) this.chip.complain(`SSI: transfers of ${bits} bits are not in the model`);
    if (now >= this.busy_until && !this.selected_by_force) this.flash.deselect();
    const start = Math.max(now, this.busy_until);
    this.busy_until = start + bits * Math.max(2, this.registers.get(0x14));
    const answer = this.flash.exchange(value & 0xff);
    if (answer === undefined) {
      this.chip.complain(`flash: command 0x${this.flash.command[0].toString(16)} is not in the model`);
    }
    if (((this.registers.get(0) >>> 8) & 3) !== 1 && this.rx.length < FIFO_DEPTH) {
      this.rx.push({ value: answer ?? 0xff, cycle: this.busy_until });
    }
  }

  received() {
    const { now } = this.chip.queue;
    let count = 0;
    while (count < this.rx.length && this.rx[count].cycle <= now) count++;
    return count;
  }

  waiting_to_send() {
    const bits = 8 * Math.max(2, this.registers.get(0x14));
    return Math.max(0, Math.ceil((this.busy_until - this.chip.queue.now) / bits) - 1);
  }

  status() {
    const waiting = this.waiting_to_send();
    const received = this.received();
    return (this.busy_until > this.chip.queue.now ? 1 : 0) | (waiting < FIFO_DEPTH ? 2 : 0) | (waiting === 0 ? 4 : 0) |
      (received > 0 ? 8 : 0) | (received === FIFO_DEPTH ? 16 : 0);
  }

  read(offset) {
    if (offset >= 0x60 && offset < 0xf0) return this.received() > 0 ? this.rx.shift().value : 0;
    switch (offset) {
      case 0x08: return this.enabled ? 1 : 0;
      case 0x20: return this.waiting_to_send();
      case 0x24: return this.received();
      case 0x28: return this.status();
      case 0x38: case 0x3c: case 0x40: case 0x44: case 0x48: return 0; // interrupt clears
      case 0x58: return 0x51535049;
      case 0x5c: return 0x3430312a;
      default: return this.registers.get(offset) ?? 0;
    }
  }

  write(offset, value) {
    if (offset >= 0x60 && offset < 0xf0) {
      this.transfer(value);
    } else if (offset === 0x08) {
      this.enabled = (value & 1) !== 0;
      if (!this.enabled) {
        this.rx = [];
        this.busy_until = 0;
        this.flash.deselect();
      }
    } else {
      this.registers.set(offset, value);
    }
  }
}

/** IO_QSPI: only chip select's output override does something. */
export class IoQspi extends Block {
  constructor(chip, ssi) {
    super(chip, "IO_QSPI");
    this.ssi = ssi;
    this.registers = new Map();
  }

  reset() {
    this.registers.clear();
    this.ssi.force_select(false);
  }

  read(offset) {
    return this.registers.get(offset) ?? (offset & 4 && offset < 0x30 ? 0x1f : 0);
  }

  write(offset, value) {
    this.registers.set(offset, value);
    if (offset === 0x0c) this.ssi.force_select(((value >>> 8) & 3) === 2);
  }
}
