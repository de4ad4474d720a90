// SPDX-License-Identifier: MIT
// A PIO block: registers, FIFOs, flags and interrupt lines of four state machines that run in lockstep.
import { Block } from "./block.js";
import { Machine, STALL_IRQ, STALL_INPUT, STALL_NONE, STALL_RX, STALL_TX } from "./pio_machine.js";

export class Pio extends Block {
  constructor(chip, index, first_irq) {
    super(chip, `PIO${index}`);
    this.index = index;
    this.pins = chip.pins;
    this.first_irq = first_irq;
    this.reset();
  }

  reset() {
    this.memory = new Uint16Array(32);
    this.machines = [0, 1, 2, 3].map((index) => new Machine(this, index));
    this.irq_flags = 0;
    this.raise = 0; // flags that machines raise and clear in this cycle; seen by others in the next
    this.clear = 0;
    this.debug = 0;
    this.sync_bypass = 0;
    this.enables = [0, 0]; // IRQ0_INTE, IRQ1_INTE
    this.forces = [0, 0];
    this.out = 0; // what the block drives, and where
    this.oe = 0;
    this.changed = 0; // pins of `out` or `oe` that changed in this cycle
    this.next = Infinity;
    this.update_irq();
    this.pins.update(0x3fffffff, this.chip.queue.now + 1);
  }

  // ---- time

  /** Runs all machines that have something to do at cycle `next`. */
  step() {
    const cycle = this.next;
    this.chip.queue.now = cycle;
    for (const machine of this.machines) {
      if (machine.next === cycle) machine.step(cycle);
    }
    this.commit(cycle);
  }

  /** What machines did in one cycle becomes visible in the next. */
  commit(cycle) {
    if (this.raise | this.clear) {
      this.irq_flags = ((this.irq_flags & ~this.clear) | this.raise) & 0xff;
      this.raise = 0;
      this.clear = 0;
      this.wake_stalled(STALL_IRQ, cycle + 1);
      this.update_irq();
    }
    if (this.changed !== 0) {
      const changed = this.changed;
      this.changed = 0;
      this.pins.update(changed, cycle + 1);
    }
    this.find_next();
  }

  find_next() {
    const [a, b, c, d] = this.machines;
    this.next = Math.min(a.next, b.next, c.next, d.next);
    this.chip.queue.wake(this.next);
  }

  wake_stalled(reason, cycle) {
    for (const machine of this.machines) {
      if (machine.stall === reason) machine.wake(cycle);
    }
  }

  /** Inputs change at that cycle; machines see it two later, or at once where the synchroniser is bypassed. */
  inputs_changed(cycle, changed) {
    const seen = changed & this.sync_bypass ? cycle : cycle + 2;
    for (const machine of this.machines) {
      if (machine.loop !== null && machine.loop.pin & changed) machine.settle(this.chip.queue.now);
      if (machine.stall === STALL_INPUT) machine.wake(Math.max(seen, this.chip.queue.now + 1));
    }
    this.find_next();
  }

  settle() {
    for (const machine of this.machines) machine.settle(this.chip.queue.now);
  }

  // ---- what machines do to the block

  raise_flag(flag) {
    this.raise |= flag;
  }

  clear_flag(flag) {
    this.clear |= flag;
  }

  fifo_changed() {
    if (this.enables[0] | this.enables[1]) this.update_irq();
  }

  /** Returns whether a pin changed. */
  write_pins(base, width, value) {
    const [mask, bits] = spread(base, width, value);
    const changed = (this.out ^ bits) & mask;
    this.out ^= changed;
    this.changed |= changed;
    return changed !== 0;
  }

  write_directions(base, width, value) {
    const [mask, bits] = spread(base, width, value);
    const changed = (this.oe ^ bits) & mask;
    this.oe ^= changed;
    this.changed |= changed;
    return changed !== 0;
  }

  // ---- interrupts

  raw_interrupts() {
    let raw = (this.irq_flags & 15) << 8;
    for (const machine of this.machines) {
      if (machine.rx.length > 0) raw |= machine.bit;
      if (machine.tx.length < machine.tx_depth) raw |= machine.bit << 4;
    }
    return raw;
  }

  update_irq() {
    const raw = this.enables[0] | this.enables[1] ? this.raw_interrupts() : 0;
    for (let line = 0; line < 2; line++) {
      const status = (raw & this.enables[line]) | this.forces[line];
      this.chip.core.setInterrupt(this.first_irq + line, status !== 0);
    }
  }

  // ---- registers

  read(offset) {
    if (offset >= 0x20 && offset < 0x30) return this.read_fifo(this.machines[(offset - 0x20) >>> 2]);
    if (offset >= 0x48 && offset < 0xc8) return 0; // instruction memory cannot be read
    if (offset >= 0xc8 && offset < 0x128) {
      return this.read_machine(this.machines[Math.floor((offset - 0xc8) / 0x18)], (offset - 0xc8) % 0x18);
    }
    switch (offset) {
      case 0x00: return this.machines.reduce((bits, machine) => bits | (machine.enabled ? machine.bit : 0), 0);
      case 0x04: return this.fifo_status();
      case 0x08: return this.debug | this.present_stalls();
      case 0x0c: return this.machines.reduce((word, machine, index) =>
        word | (machine.tx.length << (8 * index)) | (machine.rx.length << (8 * index + 4)), 0);
      case 0x30: return this.irq_flags;
      case 0x34: return 0;
      case 0x38: return this.sync_bypass;
      case 0x3c: return this.out;
      case 0x40: return this.oe;
      case 0x44: return 0x00200404;
      case 0x128: return this.raw_interrupts();
      case 0x12c: case 0x138: return this.enables[offset === 0x12c ? 0 : 1];
      case 0x130: case 0x13c: return this.forces[offset === 0x130 ? 0 : 1];
      case 0x134: return (this.raw_interrupts() & this.enables[0]) | this.forces[0];
      case 0x140: return (this.raw_interrupts() & this.enables[1]) | this.forces[1];
      default: return offset >= 0x10 && offset < 0x20 ? 0 : this.unknown("read", offset);
    }
  }

  fifo_status() {
    let word = 0;
    for (const machine of this.machines) {
      if (machine.tx.length === 0) word |= machine.bit << 24;
      if (machine.tx.length >= machine.tx_depth) word |= machine.bit << 16;
      if (machine.rx.length === 0) word |= machine.bit << 8;
      if (machine.rx.length >= machine.rx_depth) word |= machine.bit;
    }
    return word;
  }

  /** Stalls that last are seen again at once when FDEBUG is cleared. */
  present_stalls() {
    let bits = 0;
    for (const machine of this.machines) {
      if (!machine.enabled) continue;
      if (machine.stall === STALL_TX) bits |= machine.bit << 24;
      if (machine.stall === STALL_RX) bits |= machine.bit;
    }
    return bits;
  }

  read_fifo(machine) {
    if (machine.rx.length === 0) {
      this.debug |= machine.bit << 8; // RXUNDER
      return 0;
    }
    const word = machine.rx.shift();
    if (machine.stall === STALL_RX) machine.wake(this.chip.queue.now + 1);
    this.fifo_changed();
    this.find_next();
    return word;
  }

  read_machine(machine, offset) {
    machine.settle(this.chip.queue.now);
    this.find_next();
    switch (offset) {
      case 0x00: return machine.divider.register;
      case 0x04: return machine.execctrl | (machine.exec >= 0 && machine.stall !== STALL_NONE ? 1 << 31 : 0);
      case 0x08: return machine.shiftctrl;
      case 0x0c: return machine.pc;
      case 0x10: return machine.exec >= 0 ? machine.exec : this.memory[machine.pc];
      default: return machine.pinctrl;
    }
  }

  write(offset, value) {
    const { now } = this.chip.queue;
    if (offset >= 0x10 && offset < 0x20) return this.write_fifo(this.machines[(offset - 0x10) >>> 2], value, now);
    this.settle();
    if (offset >= 0x48 && offset < 0xc8) {
      this.memory[(offset - 0x48) >>> 2] = value;
    } else if (offset >= 0xc8 && offset < 0x128) {
      this.write_machine(this.machines[Math.floor((offset - 0xc8) / 0x18)], (offset - 0xc8) % 0x18, value, now);
    } else {
      this.write_block(offset, value, now);
    }
    const forces = offset >= 0xc8 && offset < 0x128 && (offset - 0xc8) % 0x18 === 0x10; // done a cycle later
    this.commit(forces ? now + 1 : now);
    return undefined;
  }

  write_block(offset, value, now) {
    switch (offset) {
      case 0x00: this.write_control(value, now); break;
      case 0x08: this.debug &= ~this.raw; break;
      case 0x30: this.clear |= this.raw & 0xff; break;
      case 0x34: this.raise |= this.raw & 0xff; break;
      case 0x38: this.sync_bypass = value; break;
      case 0x12c: case 0x138: this.enables[offset === 0x12c ? 0 : 1] = value & 0xfff; this.update_irq(); break;
      case 0x130: case 0x13c: this.forces[offset === 0x130 ? 0 : 1] = value & 0xfff; this.update_irq(); break;
      default: this.unknown("write", offset);
    }
  }

  write_control(value, now) {
    for (const machine of this.machines) {
      const bit = machine.bit;
      if (value & (bit << 4)) {
        machine.restart();
        if (machine.enabled) machine.next = machine.divider.first_tick_from(now + 1);
      }
      if (value & (bit << 8)) machine.restart_divider(now);
      machine.enable((value & bit) !== 0, now);
    }
  }

  write_fifo(machine, value, now) {
    if (machine.tx.length >= machine.tx_depth) {
      this.debug |= machine.bit << 16; // TXOVER
      return;
    }
    machine.tx.push(value >>> 0);
    if (machine.stall === STALL_TX) machine.wake(now + 1);
    else if (machine.enabled && machine.shiftctrl & 0x20000 && machine.next > now + 1) machine.refill();
    this.fifo_changed();
    this.find_next();
  }

  write_machine(machine, offset, value, now) {
    switch (offset) {
      case 0x00: machine.divider.write(value); break;
      case 0x04:
        if (value & 0x00060000) this.chip.complain(`${this.name}: OUT_STICKY and INLINE_OUT_EN are not in the model`);
        machine.execctrl = value & 0x7fffff9f;
        break;
      case 0x08: this.write_shift_control(machine, value & 0xffff0000); break;
      case 0x10: machine.force(value & 0xffff, now); break;
      case 0x14: machine.pinctrl = value; break;
    }
  }

  /** Joining or parting the FIFOs empties them. */
  write_shift_control(machine, value) {
    if ((machine.shiftctrl ^ value) & 0xc0000000) {
      machine.tx = [];
      machine.rx = [];
    }
    machine.shiftctrl = value >>> 0;
    this.update_irq();
  }
}

/** The mask of `width` pins from `base` on, around the end, and the bits of `value` in it. */
function spread(base, width, value) {
  const mask = width >= 32 ? 0xffffffff : (1 << width) - 1;
  const bits = value & mask;
  if (base === 0) return [mask, bits];
  return [(mask << base) | (mask >>> (32 - base)), (bits << base) | (bits >>> (32 - base))];
}
