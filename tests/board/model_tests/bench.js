// SPDX-License-Identifier: MIT
// A chip without firmware whose registers a test writes as the processor would, and an assembler for PIO programs.
import { Chip } from "../sim/chip.js";

export const PIO0 = 0x50200000, PIO1 = 0x50300000;
export const CTRL = 0x00, FSTAT = 0x04, FDEBUG = 0x08, FLEVEL = 0x0c, TXF0 = 0x10, RXF0 = 0x20, IRQ = 0x30;
export const CLKDIV = 0xc8, EXECCTRL = 0xcc, SHIFTCTRL = 0xd0, ADDR = 0xd4, INSTR = 0xd8, PINCTRL = 0xdc, STRIDE = 0x18;

/** The chip runs, but its processor stands still: all peripherals are out of reset. */
export class Bench {
  constructor() {
    this.chip = new Chip();
    this.chip.core.stopped = true;
    this.write(0x4000f000, 0x01ffffff); // RESETS, CLEAR alias
  }

  write(address, value) {
    this.chip.core.writeUint32(address, value >>> 0);
  }

  read(address) {
    return this.chip.core.readUint32(address);
  }

  get cycle() {
    return this.chip.queue.now;
  }

  run(cycles) {
    this.chip.run_until(this.cycle + cycles);
  }

  /** Runs to the end of a cycle that is counted from `start`. */
  run_to(cycle) {
    this.chip.run_until(cycle);
  }

  /** Gives pins to a PIO block, as outputs driven low, and watches them. */
  pio_outputs(block, ...pins) {
    const pio = this.chip.pio[block];
    for (const pin of pins) {
      this.write(0x40014004 + 8 * pin, 6 + block);
      pio.write_directions(pin, 1, 1);
      pio.commit(this.cycle);
      this.chip.pins.watch(pin);
    }
  }

  /** Edges of a pin after the first entry, as [cycle - origin, level]. */
  edges(pin, origin) {
    return this.chip.pins.log.get(pin).slice(1).map((entry) => [Math.floor(entry / 2) - origin, entry % 2]);
  }

  /** Loads a program at 0 and sets up state machine 0 of PIO0; wraps at its end unless told otherwise. */
  load(program, { block = PIO0, at = 0, machine = 0, pinctrl = 0, execctrl = 0, shiftctrl = 0x000c0000,
    clkdiv = 0x10000, wrap = [at, at + program.length - 1] } = {}) {
    program.forEach((word, index) => this.write(block + 0x48 + 4 * (at + index), word));
    const base = block + STRIDE * machine;
    this.write(base + CLKDIV, clkdiv);
    this.write(base + EXECCTRL, execctrl | (wrap[1] << 12) | (wrap[0] << 7));
    this.write(base + SHIFTCTRL, shiftctrl);
    this.write(base + PINCTRL, pinctrl);
    this.write(base + INSTR, at); // jmp to the start
  }

  /** Enables machines of a block, their dividers in phase; returns the cycle of their first instruction. */
  enable(mask = 1, block = PIO0) {
    this.write(block + CTRL, mask | (mask << 8));
    return this.cycle + 1;
  }
}

/** PINCTRL from its fields. */
export function pinctrl({ side_count = 0, set_count = 0, out_count = 0, in_base = 0, side_base = 0, set_base = 0,
  out_base = 0 }) {
  return ((side_count << 29) | (set_count << 26) | (out_count << 20) | (in_base << 15) | (side_base << 10) |
    (set_base << 5) | out_base) >>> 0;
}

/** Instructions; `field` is the five bits of delay and side-set. */
const code = (op, argument, field) => (op << 13) | (field << 8) | argument;
export const JMP = { always: 0, not_x: 1, x_dec: 2, not_y: 3, y_dec: 4, x_ne_y: 5, pin: 6, not_osre: 7 };
export const jmp = (target, condition = 0, field = 0) => code(0, (condition << 5) | target, field);
export const WAIT = { gpio: 0, pin: 1, irq: 2 };
export const wait = (polarity, source, index, field = 0) => code(1, (polarity << 7) | (source << 5) | index, field);
export const FROM = { pins: 0, x: 1, y: 2, null: 3, status: 5, isr: 6, osr: 7 };
export const in_ = (source, count, field = 0) => code(2, (source << 5) | (count & 31), field);
export const TO = { pins: 0, x: 1, y: 2, null: 3, pindirs: 4, pc: 5, isr: 6, exec: 7 };
export const out = (target, count, field = 0) => code(3, (target << 5) | (count & 31), field);
export const push = ({ iffull = 0, block = 1 } = {}, field = 0) => code(4, (iffull << 6) | (block << 5), field);
export const pull = ({ ifempty = 0, block = 1 } = {}, field = 0) =>
  code(4, 0x80 | (ifempty << 6) | (block << 5), field);
export const MOV_TO = { pins: 0, x: 1, y: 2, exec: 4, pc: 5, isr: 6, osr: 7 };
export const mov = (target, source, operation = 0, field = 0) =>
  code(5, (target << 5) | (operation << 3) | source, field);
export const irq = (index, { clear = 0, wait_for = 0 } = {}, field = 0) =>
  code(6, (clear << 6) | (wait_for << 5) | index, field);
export const SET_TO = { pins: 0, x: 1, y: 2, pindirs: 4 };
export const set = (target, value, field = 0) => code(7, (target << 5) | value, field);
export const NOP = mov(MOV_TO.y, FROM.y);
