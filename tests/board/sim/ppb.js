// SPDX-License-Identifier: MIT
// The processor's private registers: SysTick (true to the cycle, awake or asleep), interrupt controller, system
// control.
import { Block } from "./block.js";

const TOP = 0xffffff;

export class PrivateBlock extends Block {
  constructor(chip, core, clock) {
    super(chip, "PPB");
    this.core = core;
    this.control = 0; // SYST_CSR bits 0..2
    this.reload = 0;
    this.value = 0; // counter at `base`
    this.base = 0;
    this.seen_zeros = 0; // of the zeros since `base`, so many have been told
    this.count_flag = false;
    this.alarm = clock.createAlarm(() => this.systick_zero());
    this.scr = 0;
  }

  // ---- SysTick: with the processor clock one step a cycle, with the reference one a microsecond

  get step_cycles() {
    return this.control & 4 ? 1 : 125;
  }

  steps() {
    return this.control & 1 ? Math.floor((this.chip.queue.now - this.base) / this.step_cycles) : 0;
  }

  counter() {
    const steps = this.steps();
    if (steps <= this.value) return this.value - steps;
    if (this.reload === 0) return 0;
    const beyond = (steps - this.value - 1) % (this.reload + 1);
    return this.reload - beyond;
  }

  zeros() {
    const steps = this.steps();
    if (!(this.control & 1) || steps < this.value) return 0;
    const first = this.value > 0 ? 1 : 0;
    return this.reload === 0 ? first : first + Math.floor((steps - this.value) / (this.reload + 1));
  }

  rebase() {
    const now = this.counter();
    if (this.zeros() > this.seen_zeros) this.count_flag = true;
    if (this.control & 1) this.base += this.steps() * this.step_cycles;
    else this.base = this.chip.queue.now;
    this.value = now;
    this.seen_zeros = 0;
  }

  arm() {
    if ((this.control & 3) !== 3) return this.alarm.cancel();
    const left = this.counter() || this.reload + 1;
    const steps = this.steps() + left;
    return this.alarm.at(this.base + steps * this.step_cycles);
  }

  systick_zero() {
    this.core.pendingSystick = true;
    this.core.interruptsUpdated = true;
    if (this.reload !== 0) this.alarm.at(this.alarm.cycle + (this.reload + 1) * this.step_cycles);
  }

  write_systick(offset, value) {
    this.rebase();
    if (offset === 0x010) {
      if (!(this.control & 1)) this.base = this.chip.queue.now;
      this.control = value & 7;
    } else if (offset === 0x014) {
      this.reload = value & TOP;
    } else {
      this.value = 0;
      this.base = this.chip.queue.now;
      this.count_flag = false;
    }
    this.arm();
  }

  read_control() {
    const flag = this.count_flag || this.zeros() > this.seen_zeros;
    this.count_flag = false;
    this.seen_zeros = this.zeros();
    return (flag ? 1 << 16 : 0) | this.control;
  }

  // ---- registers

  read(offset) {
    const { core } = this;
    if (offset >= 0x400 && offset < 0x420) return this.priorities((offset - 0x400) >>> 2);
    switch (offset) {
      case 0x010: return this.read_control();
      case 0x014: return this.reload;
      case 0x018: return this.counter();
      case 0x01c: return 0xc0000000;
      case 0x100: case 0x180: return core.enabledInterrupts;
      case 0x200: case 0x280: return core.pendingInterrupts;
      case 0xd00: return 0x410cc601;
      case 0xd04: return this.interrupt_state();
      case 0xd08: return core.VTOR;
      case 0xd0c: return 0xfa050000;
      case 0xd10: return this.scr;
      case 0xd14: return 0x208;
      case 0xd1c: return core.SHPR2;
      case 0xd20: return core.SHPR3;
      default: return this.unknown("read", offset);
    }
  }

  interrupt_state() {
    const { core } = this;
    return (core.pendingNMI ? 1 << 31 : 0) | (core.pendingPendSV ? 1 << 28 : 0) |
      (core.pendingSystick ? 1 << 26 : 0) | (core.pendingInterrupts & core.enabledInterrupts ? 1 << 22 : 0) |
      (core.vectPending << 12) | core.IPSR;
  }

  priorities(index) {
    let word = 0;
    for (let lane = 0; lane < 4; lane++) word |= core_priority(this.core, 4 * index + lane) << (8 * lane + 6);
    return word;
  }

  write(offset, value) {
    const { core } = this;
    if (offset >= 0x400 && offset < 0x420) return this.write_priorities((offset - 0x400) >>> 2, value);
    switch (offset) {
      case 0x010: case 0x014: case 0x018: this.write_systick(offset, value); break;
      case 0x100: core.enabledInterrupts |= value; break;
      case 0x180: core.enabledInterrupts &= ~value; break;
      case 0x200: core.pendingInterrupts |= value; break;
      case 0x280: core.clear_pending(value); break;
      case 0xd04:
        if (value & (1 << 31)) core.pendingNMI = true;
        if (value & (1 << 28)) core.pendingPendSV = true;
        if (value & (1 << 27)) core.pendingPendSV = false;
        if (value & (1 << 26)) core.pendingSystick = true;
        if (value & (1 << 25)) core.pendingSystick = false;
        break;
      case 0xd08: core.VTOR = value & 0xffffff00; break;
      case 0xd0c:
        if (value >>> 16 === 0x05fa && value & 4) this.chip.request_reset("AIRCR");
        break;
      case 0xd10: this.scr = value & 0x16; core.sleep_on_exit = (value & 2) !== 0; break;
      case 0xd1c: core.SHPR2 = value; break;
      case 0xd20: core.SHPR3 = value; break;
      default: this.unknown("write", offset);
    }
    core.interruptsUpdated = true;
    return undefined;
  }

  write_priorities(index, value) {
    for (let lane = 0; lane < 4; lane++) {
      const bit = 1 << (4 * index + lane);
      for (let priority = 0; priority < 4; priority++) this.core.interruptPriorities[priority] &= ~bit;
      this.core.interruptPriorities[(value >>> (8 * lane + 6)) & 3] |= bit;
    }
    this.core.interruptsUpdated = true;
  }
}

function core_priority(core, irq) {
  return core.interruptPriorities.findIndex((mask) => mask & (1 << irq));
}
