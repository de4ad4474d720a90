// SPDX-License-Identifier: MIT
// A state machine's clock divider: tick n comes n * divisor cycles after tick 0, rounded down; it runs whether the
// machine does or not (datasheet, 3.5.5).

export class ClockDivider {
  constructor() {
    this.tick = 0; // a cycle in which it ticked, and what was left of a cycle then, in 256ths
    this.fraction = 0;
    this.write(0x00010000);
  }

  /** SMx_CLKDIV: 16 bits of whole cycles, 8 of 256ths; 0 means 65536. */
  write(value) {
    this.register = value & 0xffffff00;
    this.whole = this.register >>> 16 || 0x10000;
    this.part = this.register >>> 16 ? (this.register >>> 8) & 0xff : 0;
    this.is_one = this.whole === 1 && this.part === 0;
  }

  /** Phase 0 is the cycle after the write of CTRL.CLKDIV_RESTART. */
  restart(now) {
    this.tick = now + 1;
    this.fraction = 0;
  }

  /** The cycle `count` ticks after `tick`. */
  cycle_of(count) {
    return this.tick + count * this.whole + Math.floor((this.fraction + count * this.part) / 256);
  }

  /** So many ticks on; returns the cycle. */
  move(count) {
    const cycle = this.cycle_of(count);
    this.fraction = (this.fraction + count * this.part) % 256;
    this.tick = cycle;
    return cycle;
  }

  /** How many ticks come after `tick`, up to that cycle and with it. */
  ticks_until(cycle) {
    if (cycle <= this.tick) return 0;
    let count = Math.floor(((cycle - this.tick + 1) * 256) / (256 * this.whole + this.part));
    while (this.cycle_of(count) > cycle) count--;
    while (this.cycle_of(count + 1) <= cycle) count++;
    return count;
  }

  /** Moves to the first tick at that cycle or later. */
  first_tick_from(cycle) {
    if (cycle <= this.tick) return this.tick;
    if (this.is_one) {
      this.tick = cycle;
      return cycle;
    }
    return this.move(this.ticks_until(cycle - 1) + 1);
  }

  /** Ticks from one cycle in which it ticked to another. */
  ticks_between(from, to) {
    return this.is_one ? to - from : Math.round(((to - from) * 256) / (256 * this.whole + this.part));
  }
}
