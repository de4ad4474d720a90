// SPDX-License-Identifier: MIT
// The 30 pins: IO_BANK0 and PADS_BANK0, what leaves and enters each pad, edges with their cycle, wires, interrupts.
import { Block } from "./block.js";

const COUNT = 30;
const ALL = 0x3fffffff;
const HISTORY = 8; // input words that are remembered for the synchronisers
const IRQ_IO_BANK0 = 13;
const FUNCTION_PWM = 4, FUNCTION_SIO = 5, FUNCTION_PIO0 = 6, FUNCTION_PIO1 = 7, FUNCTION_NONE = 31;
const PULL_DOWN = 4, PULL_UP = 8, INPUT_ENABLE = 0x40, OUTPUT_DISABLE = 0x80, PAD_AT_RESET = 0x56;

/** OUTOVER, OEOVER, INOVER, IRQOVER: as it is, inverted, low, high. */
function overridden(level, override) {
  return override === 0 ? level : override === 1 ? level ^ 1 : override - 2;
}

export class Pins {
  constructor(chip) {
    this.chip = chip;
    this.ctrl = new Uint32Array(COUNT).fill(FUNCTION_NONE);
    this.pad = new Uint32Array(COUNT).fill(PAD_AT_RESET);
    this.level = 0; // of each pad
    this.driven = 0; // pads that the outside drives, and to what
    this.drive = 0;
    this.wires = new Map(); // output pin -> input pins
    this.log = new Map(); // pin -> [cycle * 2 + level, ...]
    this.listeners = new Map(); // pin -> callbacks (level, cycle)
    this.from_pad = 0; // inputs behind the pads' input enable
    this.inputs = 0; // inputs behind INOVER, as peripherals get them before they synchronise
    this.last_input_change = -10;
    this.history_cycle = new Float64Array(HISTORY).fill(-10);
    this.history_word = new Uint32Array(HISTORY);
    this.history_at = 0;
    this.edges_seen = new Uint8Array(COUNT); // INTR: bit 2 falling, bit 3 rising
    this.enables = new Uint8Array(COUNT);
    this.forces = new Uint8Array(COUNT);
    this.io = new IoBank(chip, this);
    this.pads = new PadBank(chip, this);
  }

  // ---- for tests

  /** Keeps the edges of a pin from now on; the first entry is its level now. */
  watch(pin) {
    this.log.set(pin, [this.chip.queue.now * 2 + this.read(pin)]);
  }

  read(pin) {
    return (this.level >>> pin) & 1;
  }

  /** The outside drives the pad; undefined: lets go of it. */
  drive_pin(pin, level, cycle = this.chip.queue.now) {
    const bit = 1 << pin;
    if (level === undefined) {
      this.driven &= ~bit;
    } else {
      this.driven |= bit;
      this.drive = level ? this.drive | bit : this.drive & ~bit;
    }
    this.update(bit, cycle);
  }

  /** A wire from an output to an input, without delay. */
  connect(from, to) {
    if (!this.wires.has(from)) this.wires.set(from, []);
    this.wires.get(from).push(to);
    this.drive_pin(to, this.read(from));
  }

  disconnect(from, to) {
    this.wires.set(from, (this.wires.get(from) ?? []).filter((pin) => pin !== to));
    this.drive_pin(to, undefined);
  }

  on_edge(pin, callback) {
    if (!this.listeners.has(pin)) this.listeners.set(pin, []);
    this.listeners.get(pin).push(callback);
  }

  // ---- levels

  /** Works out the given pins anew; what changes does so at that cycle. */
  update(mask, cycle) {
    let { from_pad, inputs } = this;
    let left = mask & ALL;
    while (left !== 0) {
      const pin = 31 - Math.clz32(left);
      const bit = 1 << pin;
      left ^= bit;
      const level = this.pad_level(pin);
      if (((this.level >>> pin) & 1) !== level) this.level_changed(pin, level, cycle);
      const seen = this.pad[pin] & INPUT_ENABLE ? level : 0;
      from_pad = seen ? from_pad | bit : from_pad & ~bit;
      inputs = overridden(seen, (this.ctrl[pin] >>> 16) & 3) ? inputs | bit : inputs & ~bit;
    }
    // A wire may have changed other pins meanwhile: only those of the mask are ours.
    from_pad = (this.from_pad & ~mask) | (from_pad & mask);
    inputs = (this.inputs & ~mask) | (inputs & mask);
    if (from_pad !== this.from_pad) this.pads_changed(from_pad);
    if (inputs !== this.inputs) this.inputs_changed(inputs, cycle);
  }

  pad_level(pin) {
    const ctrl = this.ctrl[pin];
    let out = 0;
    let enabled = 0;
    switch (ctrl & 31) {
      case FUNCTION_PIO0: out = this.chip.pio[0].out; enabled = this.chip.pio[0].oe; break;
      case FUNCTION_PIO1: out = this.chip.pio[1].out; enabled = this.chip.pio[1].oe; break;
      case FUNCTION_SIO: out = this.chip.sio.gpioValue; enabled = this.chip.sio.gpioOutputEnable; break;
      case FUNCTION_PWM: out = this.chip.rp.pwm.gpioValue; enabled = this.chip.rp.pwm.gpioDirection; break;
    }
    const pad = this.pad[pin];
    if (overridden((enabled >>> pin) & 1, (ctrl >>> 12) & 3) && !(pad & OUTPUT_DISABLE)) {
      return overridden((out >>> pin) & 1, (ctrl >>> 8) & 3);
    }
    if ((this.driven >>> pin) & 1) return (this.drive >>> pin) & 1;
    return pad & PULL_UP ? (pad & PULL_DOWN ? this.read(pin) : 1) : 0; // both: the pad keeps its level
  }

  level_changed(pin, level, cycle) {
    this.level = (this.level ^ (1 << pin)) >>> 0;
    const log = this.log.get(pin);
    if (log) log.push(cycle * 2 + level);
    const wires = this.wires.get(pin);
    if (wires) for (const to of wires) this.drive_pin(to, level, cycle);
    const listeners = this.listeners.get(pin);
    if (listeners) for (const callback of listeners) callback(level, cycle);
  }

  inputs_changed(inputs, cycle) {
    const changed = this.inputs ^ inputs;
    this.inputs = inputs;
    this.last_input_change = cycle;
    this.history_at = (this.history_at + 1) % HISTORY;
    this.history_cycle[this.history_at] = cycle;
    this.history_word[this.history_at] = inputs;
    for (const pio of this.chip.pio) pio.inputs_changed(cycle, changed);
  }

  /** What a state machine sees in that cycle: two flip-flops old, except where it bypasses them. */
  inputs_at(cycle, bypass) {
    if (this.last_input_change + 2 <= cycle) return this.inputs;
    const old = this.word_at(cycle - 2);
    return bypass === 0 ? old : (old & ~bypass) | (this.word_at(cycle) & bypass);
  }

  word_at(cycle) {
    for (let back = 0; back < HISTORY - 1; back++) {
      const at = (this.history_at + HISTORY - back) % HISTORY;
      if (this.history_cycle[at] <= cycle) return this.history_word[at];
    }
    return this.history_word[(this.history_at + 1) % HISTORY];
  }

  /** The next cycle after this one in which a change that has already happened is seen. */
  next_change_seen(cycle, bypass) {
    if (this.last_input_change + 2 <= cycle) return Infinity;
    let seen = Infinity;
    for (const changed of this.history_cycle) {
      if (bypass !== 0 && changed > cycle) seen = Math.min(seen, changed);
      if (changed + 2 > cycle) seen = Math.min(seen, changed + 2);
    }
    return seen;
  }

  // ---- interrupts, which look at the pads before INOVER

  pads_changed(from_pad) {
    let changed = this.from_pad ^ from_pad;
    this.from_pad = from_pad;
    while (changed !== 0) {
      const pin = 31 - Math.clz32(changed);
      changed ^= 1 << pin;
      this.edges_seen[pin] |= (from_pad >>> pin) & 1 ? 8 : 4;
    }
    this.update_irq();
  }

  raw_interrupts(pin) {
    return this.edges_seen[pin] | ((this.from_pad >>> pin) & 1 ? 2 : 1);
  }

  status_of_interrupts(pin) {
    return (this.raw_interrupts(pin) & this.enables[pin]) | this.forces[pin];
  }

  update_irq() {
    let wanted = 0;
    for (let pin = 0; pin < COUNT; pin++) {
      if (this.enables[pin] | this.forces[pin] | ((this.ctrl[pin] >>> 28) & 3)) {
        wanted |= overridden(this.status_of_interrupts(pin) ? 1 : 0, (this.ctrl[pin] >>> 28) & 3);
      }
    }
    this.chip.core.setInterrupt(IRQ_IO_BANK0, wanted !== 0);
  }

  reset_io() {
    this.ctrl.fill(FUNCTION_NONE);
    this.enables.fill(0);
    this.forces.fill(0);
    this.update(ALL, this.chip.queue.now);
    this.edges_seen.fill(0);
    this.update_irq();
  }

  reset_pads() {
    this.pad.fill(PAD_AT_RESET);
    this.update(ALL, this.chip.queue.now);
  }

  /** Both in one cycle, as at a reset of the chip. */
  reset() {
    this.pad.fill(PAD_AT_RESET);
    this.reset_io();
  }
}

/** IO_BANK0: STATUS and CTRL of each pin, then INTR, PROC0_INTE, PROC0_INTF, PROC0_INTS with eight pins a word. */
class IoBank extends Block {
  constructor(chip, pins) {
    super(chip, "IO_BANK0");
    this.pins = pins;
    this.other_processors = new Map(); // PROC1 and DORMANT_WAKE: kept, without effect
  }

  reset() {
    this.pins.reset_io();
  }

  read(offset) {
    const { pins } = this;
    if (offset < 8 * COUNT) return offset & 4 ? pins.ctrl[offset >>> 3] : this.status(offset >>> 3);
    const first = (offset & 0xf) * 2;
    switch (offset & 0xff0) {
      case 0x0f0: return this.gather(first, (pin) => pins.raw_interrupts(pin));
      case 0x100: return this.gather(first, (pin) => pins.enables[pin]);
      case 0x110: return this.gather(first, (pin) => pins.forces[pin]);
      case 0x120: return this.gather(first, (pin) => pins.status_of_interrupts(pin));
      default: return offset < 0x190 ? this.other_processors.get(offset) ?? 0 : this.unknown("read", offset);
    }
  }

  gather(first, bits_of) {
    let word = 0;
    for (let pin = first; pin < Math.min(first + 8, COUNT); pin++) word |= bits_of(pin) << (4 * (pin - first));
    return word;
  }

  status(pin) {
    const { pins } = this;
    const ctrl = pins.ctrl[pin];
    const irq = pins.status_of_interrupts(pin) ? 1 : 0;
    return (((pins.level >>> pin) & 1) << 9) | (((pins.from_pad >>> pin) & 1) << 17) |
      (((pins.inputs >>> pin) & 1) << 19) | (irq << 24) | (overridden(irq, (ctrl >>> 28) & 3) << 26);
  }

  write(offset, value) {
    const { pins, raw } = this;
    const { now } = this.chip.queue;
    if (offset < 8 * COUNT) {
      if (!(offset & 4)) return;
      pins.ctrl[offset >>> 3] = value;
      pins.update(1 << (offset >>> 3), now + 1);
    } else {
      const first = (offset & 0xf) * 2;
      for (let pin = first; pin < Math.min(first + 8, COUNT); pin++) {
        const shift = 4 * (pin - first);
        if ((offset & 0xff0) === 0x0f0) pins.edges_seen[pin] &= ~((raw >>> shift) & 12);
        else if ((offset & 0xff0) === 0x100) pins.enables[pin] = (value >>> shift) & 15;
        else if ((offset & 0xff0) === 0x110) pins.forces[pin] = (value >>> shift) & 15;
        else if (offset < 0x190) this.other_processors.set(offset, value);
      }
    }
    pins.update_irq();
  }
}

/** PADS_BANK0: voltage select, then one word a pin. */
class PadBank extends Block {
  constructor(chip, pins) {
    super(chip, "PADS_BANK0");
    this.pins = pins;
    this.voltage_select = 0;
    this.debug_pads = [0xda, 0x5a]; // SWCLK, SWD
  }

  reset() {
    this.pins.reset_pads();
  }

  read(offset) {
    if (offset === 0) return this.voltage_select;
    const pin = (offset >>> 2) - 1;
    if (pin < COUNT) return this.pins.pad[pin];
    return pin < COUNT + 2 ? this.debug_pads[pin - COUNT] : this.unknown("read", offset);
  }

  write(offset, value) {
    const pin = (offset >>> 2) - 1;
    if (offset === 0) {
      this.voltage_select = value & 1;
    } else if (pin < COUNT) {
      this.pins.pad[pin] = value & 0xff;
      this.pins.update(1 << pin, this.chip.queue.now + 1);
    } else if (pin < COUNT + 2) {
      this.debug_pads[pin - COUNT] = value & 0xff;
    } else {
      this.unknown("write", offset);
    }
  }
}
