// SPDX-License-Identifier: MIT
// TIMER and WATCHDOG, which share the microsecond tick that the firmware must start (WATCHDOG_TICK).
import { Block } from "./block.js";

const CYCLES_PER_US = 125;
const WRAP = 2 ** 32;

/** 64 bits of microseconds and four alarms on the lower 32. */
export class Timer extends Block {
  constructor(chip, clock) {
    super(chip, "TIMER");
    this.alarms = [0, 1, 2, 3].map((index) => clock.createAlarm(() => this.fire(index)));
    this.reset();
  }

  reset() {
    this.base = 0; // microseconds at cycle `since`
    this.since = this.chip.queue.now;
    this.running = this.chip.watchdog?.tick_runs ?? false;
    this.paused = false;
    this.latched_high = 0;
    this.written_low = 0;
    this.targets = [0, 0, 0, 0];
    this.armed = 0;
    this.intr = 0;
    this.inte = 0;
    this.intf = 0;
    for (const alarm of this.alarms) alarm.cancel();
    this.update_irq();
  }

  microseconds() {
    const counts = this.running && !this.paused;
    return counts ? this.base + Math.floor((this.chip.queue.now - this.since) / CYCLES_PER_US) : this.base;
  }

  /** Stops or starts counting, or sets the time; alarms keep their targets. */
  change(act) {
    this.base = this.microseconds();
    this.since = this.chip.queue.now;
    act();
    for (let index = 0; index < 4; index++) {
      if (this.armed & (1 << index)) this.arm(index);
    }
  }

  arm(index) {
    this.armed |= 1 << index;
    if (!this.running || this.paused) return this.alarms[index].cancel();
    const time = this.microseconds();
    const ahead = (this.targets[index] - time) % WRAP;
    const at = time + (ahead <= 0 ? ahead + WRAP : ahead);
    return this.alarms[index].at(this.since + (at - this.base) * CYCLES_PER_US);
  }

  fire(index) {
    this.armed &= ~(1 << index);
    this.intr |= 1 << index;
    this.update_irq();
  }

  update_irq() {
    const status = (this.intr & this.inte) | this.intf;
    for (let index = 0; index < 4; index++) this.chip.core.setInterrupt(index, (status & (1 << index)) !== 0);
  }

  read(offset) {
    if (offset >= 0x10 && offset < 0x20) return this.targets[(offset - 0x10) >>> 2];
    switch (offset) {
      case 0x08: return this.latched_high;
      case 0x0c: this.latched_high = Math.floor(this.microseconds() / WRAP); return this.microseconds() % WRAP;
      case 0x20: return this.armed;
      case 0x24: return Math.floor(this.microseconds() / WRAP);
      case 0x28: return this.microseconds() % WRAP;
      case 0x2c: return 7;
      case 0x30: return this.paused ? 1 : 0;
      case 0x34: return this.intr;
      case 0x38: return this.inte;
      case 0x3c: return this.intf;
      case 0x40: return (this.intr & this.inte) | this.intf;
      default: return this.unknown("read", offset);
    }
  }

  write(offset, value) {
    if (offset >= 0x10 && offset < 0x20) {
      const index = (offset - 0x10) >>> 2;
      this.targets[index] = value;
      this.arm(index);
      return;
    }
    switch (offset) {
      case 0x00: this.change(() => { this.base = value * WRAP + this.written_low; }); break;
      case 0x04: this.written_low = value; break;
      case 0x20:
        this.armed &= ~this.raw;
        for (let index = 0; index < 4; index++) if (this.raw & (1 << index)) this.alarms[index].cancel();
        break;
      case 0x2c: break;
      case 0x30: this.change(() => { this.paused = (value & 1) !== 0; }); break;
      case 0x34: this.intr &= ~this.raw; break;
      case 0x38: this.inte = value & 15; break;
      case 0x3c: this.intf = value & 15; break;
      default: this.unknown("write", offset);
    }
    this.update_irq();
  }
}

const ENABLE = 1 << 30;

/** Counts down by two each microsecond (erratum E1). Scratch registers and the reason outlive the reset it makes. */
export class Watchdog extends Block {
  constructor(chip, clock, before) {
    super(chip, "WATCHDOG");
    this.scratch = before?.scratch ?? new Uint32Array(8);
    this.reason = before?.reason ?? 0;
    this.control = 0x07000000; // PAUSE bits
    this.tick_control = 0x200;
    this.count = 0;
    this.since = 0;
    this.alarm = clock.createAlarm(() => chip.watchdog_fires(1));
  }

  /** One tick a microsecond: enabled, and as many cycles of clk_ref as that has megahertz. */
  get tick_runs() {
    const cycles = this.tick_control & 0x1ff;
    if (!(this.tick_control & 0x200) || cycles === 0) return false;
    const tick_hz = this.chip.rp.clocks.refFreq / cycles;
    if (tick_hz === 1e6) return true;
    this.chip.complain(`WATCHDOG_TICK makes ${tick_hz} ticks a second of clk_ref, not 1,000,000`);
    return false;
  }

  get counts() {
    return (this.control & ENABLE) !== 0 && this.tick_runs;
  }

  counted() {
    if (!this.counts) return this.count;
    return Math.max(0, this.count - 2 * Math.floor((this.chip.queue.now - this.since) / CYCLES_PER_US));
  }

  change(act) {
    this.count = this.counted();
    this.since = this.chip.queue.now;
    act();
    if (this.counts) this.alarm.at(this.since + Math.ceil(this.count / 2) * CYCLES_PER_US);
    else this.alarm.cancel();
  }

  read(offset) {
    if (offset >= 0x0c && offset < 0x2c) return this.scratch[(offset - 0x0c) >>> 2];
    switch (offset) {
      case 0x00: return this.control | this.counted();
      case 0x04: return 0;
      case 0x08: return this.reason;
      case 0x2c: return this.tick_control | (this.tick_control & 0x200 ? 0x400 : 0);
      default: return this.unknown("read", offset);
    }
  }

  write(offset, value) {
    if (offset >= 0x0c && offset < 0x2c) {
      this.scratch[(offset - 0x0c) >>> 2] = value;
      return;
    }
    switch (offset) {
      case 0x00:
        this.change(() => { this.control = value & 0x47000000; });
        if (this.raw >>> 31) this.chip.watchdog_fires(2);
        break;
      case 0x04: this.change(() => { this.count = value & 0xffffff; }); break;
      case 0x2c: {
        const { timer } = this.chip;
        this.change(() => { this.tick_control = value & 0x3ff & ~0x400; });
        timer.change(() => { timer.running = this.tick_runs; });
        break;
      }
      default: this.unknown("write", offset);
    }
  }
}
