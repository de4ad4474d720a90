// SPDX-License-Identifier: MIT
// One PIO state machine, true to the cycle (RP2040 datasheet, 3.2 to 3.5): the nine instructions, delay, side-set,
// divider, autopull and autopush. It is stepped only at cycles where it does something: see `next`.

import { ClockDivider } from "./clock_divider.js";

const NEVER = Infinity;
const JMP = 0, WAIT = 1, IN = 2, OUT = 3, PUSH_PULL = 4, MOV = 5, IRQ = 6, SET = 7;

// What a stalled machine waits for; it costs nothing until that changes.
export const STALL_NONE = 0, STALL_TX = 1, STALL_RX = 2, STALL_INPUT = 3, STALL_IRQ = 4, STALL_ONE_TICK = 5;

function reverse_bits(value) {
  let result = 0;
  for (let bit = 0; bit < 32; bit++) result = (result << 1) | ((value >>> bit) & 1);
  return result >>> 0;
}

/** `count` ones. */
function ones(count) {
  return count >= 32 ? 0xffffffff : (1 << count) - 1;
}

function rotate_left(value, count) {
  return count === 0 ? value >>> 0 : ((value << count) | (value >>> (32 - count))) >>> 0;
}

export class Machine {
  constructor(pio, index) {
    this.pio = pio;
    this.index = index;
    this.bit = 1 << index;
    this.enabled = false;
    this.divider = new ClockDivider();
    this.execctrl = 0x0001f000;
    this.shiftctrl = 0x000c0000;
    this.pinctrl = 0x14000000;
    this.tx = [];
    this.rx = [];
    this.pc = 0;
    this.x = 0;
    this.y = 0;
    this.osr = 0;
    this.next = NEVER; // cycle of the next step; NEVER: stalled or disabled
    this.instruction = 0;
    this.restart();
  }

  /** CTRL.SM_RESTART: forgets counters, delays and stalls; x, y, OSR, program counter and FIFOs stay. */
  restart() {
    this.loop = null; // a loop of jumps only that is skipped over, see look_for_loop()
    this.isr = 0;
    this.isr_count = 0;
    this.osr_count = 32; // shifted out: 32 means empty
    this.stall = STALL_NONE;
    this.exec = -1; // an instruction to do instead of the one at pc
    this.irq_sent = false; // IRQ with wait: the flag has been raised
    this.in_shifted = false; // IN stalled on a full FIFO: the bits are in
    this.exec_is_new = false;
    this.jumped = false;
    this.jumps_only = false; // since the last backward jump
    this.compares = false;
    this.reads_pin = false;
    this.probe = null; // the last backward jump
  }

  get tx_depth() {
    return this.shiftctrl & 0x40000000 ? 8 : this.shiftctrl >>> 31 ? 0 : 4;
  }

  get rx_depth() {
    return this.shiftctrl >>> 31 ? 8 : this.shiftctrl & 0x40000000 ? 0 : 4;
  }

  get pull_threshold() {
    return (this.shiftctrl >>> 25) & 31 || 32;
  }

  get push_threshold() {
    return (this.shiftctrl >>> 20) & 31 || 32;
  }

  // ---- running

  restart_divider(now) {
    this.divider.restart(now);
    if (this.enabled && this.next !== NEVER) this.next = this.divider.tick;
  }

  enable(on, now) {
    if (on === this.enabled) return;
    this.enabled = on;
    this.jumps_only = false;
    this.next = NEVER;
    if (on) this.wake(now + 1);
  }

  /** Tries again at the first tick from that cycle on. */
  wake(cycle) {
    if (this.enabled && cycle < this.next) this.next = this.divider.first_tick_from(cycle);
  }

  /** Called at cycle `next`. */
  step(cycle) {
    if (this.loop !== null) this.end_loop(this.loop.count);
    this.divider.tick = cycle;
    const forced = this.exec >= 0;
    const word = forced ? this.exec : this.pio.memory[this.pc];
    const ticks = this.execute(word, cycle, forced);
    if (this.stall !== STALL_NONE) this.next = this.retry_at(cycle);
    else if (this.loop === null) this.next = this.divider.move(ticks);
  }

  /** A stalled machine sleeps, except while an input change is on its way through the synchroniser. */
  retry_at(cycle) {
    if (this.stall === STALL_ONE_TICK) return this.divider.first_tick_from(cycle + 1);
    if (this.stall !== STALL_INPUT) return NEVER;
    const seen = this.pio.pins.next_change_seen(cycle, this.pio.sync_bypass);
    return seen === NEVER ? NEVER : this.divider.first_tick_from(seen);
  }

  /** Does one instruction; returns the ticks until the next one, its delay included. */
  execute(word, cycle, forced) {
    this.stall = STALL_NONE;
    this.instruction = word;
    const field = (word >>> 8) & 31;
    const delay = this.delay_of(field);
    const pc_before = this.pc;
    const argument = word & 0xff;
    const operation = word >>> 13;
    if (this.shiftctrl & 0x20000 && operation !== OUT) this.refill();
    if (operation === JMP) this.side_set(field);
    switch (operation) {
      case JMP: return this.do_jmp(argument, cycle, delay, forced);
      case WAIT: this.do_wait(argument, cycle); break;
      case IN: this.do_in(argument, cycle); break;
      case OUT: this.do_out(argument); break;
      case PUSH_PULL: this.do_push_pull(argument); break;
      case MOV: this.do_mov(argument, cycle); break;
      case IRQ: this.do_irq(argument); break;
      case SET: this.do_set(argument); break;
    }
    this.side_set(field); // behind what the instruction writes: on the same pin side-set wins
    if (word !== 0xa042) this.jumps_only = false; // 0xa042: nop
    if (this.stall !== STALL_NONE) return 0;
    const sets_exec = this.exec >= 0 && this.exec_is_new;
    this.exec_is_new = false;
    if (!sets_exec) this.exec = -1;
    if (!forced && !this.jumped) this.advance_from(pc_before);
    this.jumped = false;
    return sets_exec ? 1 : 1 + delay;
  }

  advance_from(pc) {
    this.pc = pc === ((this.execctrl >>> 12) & 31) ? (this.execctrl >>> 7) & 31 : (pc + 1) & 31;
  }

  /** The part of the five bits that side-set leaves to the delay. */
  delay_of(field) {
    return field & ones(5 - (this.pinctrl >>> 29));
  }

  side_set(field) {
    let bits = this.pinctrl >>> 29;
    if (bits === 0) return;
    let value = field >>> (5 - bits);
    if (this.execctrl & 0x40000000) {
      bits--;
      if (!(value >>> bits)) return;
      value &= ones(bits);
    }
    const base = (this.pinctrl >>> 10) & 31;
    const changed = this.execctrl & 0x20000000 ? this.pio.write_directions(base, bits, value)
                                                : this.pio.write_pins(base, bits, value);
    if (changed) this.jumps_only = false;
  }

  inputs(cycle) {
    return this.pio.pins.inputs_at(cycle, this.pio.sync_bypass);
  }

  rotated_inputs(cycle) {
    const base = (this.pinctrl >>> 15) & 31;
    return rotate_left(this.inputs(cycle), (32 - base) & 31);
  }

  // ---- instructions

  do_jmp(argument, cycle, delay, forced) {
    const target = argument & 31;
    let taken = true;
    switch (argument >>> 5) {
      case 0: break;
      case 1: taken = this.x === 0; break;
      case 2: taken = this.x !== 0; this.x = (this.x - 1) >>> 0; break;
      case 3: taken = this.y === 0; break;
      case 4: taken = this.y !== 0; this.y = (this.y - 1) >>> 0; break;
      case 5: taken = this.x !== this.y; this.compares = true; break;
      case 6:
        taken = ((this.inputs(cycle) >>> ((this.execctrl >>> 24) & 31)) & 1) !== 0;
        this.reads_pin = true;
        break;
      case 7: taken = this.osr_count < this.pull_threshold; break;
    }
    const from = this.pc;
    this.exec = -1;
    if (!taken) {
      if (!forced) this.advance_from(from);
    } else {
      this.pc = target;
      if (!forced && target <= from) this.look_for_loop(from, cycle, 1 + delay);
      else if (forced) this.jumps_only = false;
    }
    return 1 + delay;
  }

  do_wait(argument, cycle) {
    const polarity = argument >>> 7;
    const index = argument & 31;
    const source = (argument >>> 5) & 3;
    if (source === 2) {
      const flag = 1 << this.irq_index(index);
      const raised = (this.pio.irq_flags & flag) !== 0;
      if (raised !== (polarity === 1)) this.stall = STALL_IRQ;
      else if (polarity === 1) this.pio.clear_flag(flag);
    } else {
      const pin = source === 0 ? index : (index + ((this.pinctrl >>> 15) & 31)) & 31;
      if (((this.inputs(cycle) >>> pin) & 1) !== polarity) this.stall = STALL_INPUT;
    }
  }

  irq_index(index) {
    return index & 0x10 ? (index & 4) | ((index + this.index) & 3) : index & 7;
  }

  do_in(argument, cycle) {
    const count = argument & 31 || 32;
    if (!this.in_shifted) {
      let data = 0;
      switch (argument >>> 5) {
        case 0: data = this.rotated_inputs(cycle); break;
        case 1: data = this.x; break;
        case 2: data = this.y; break;
        case 6: data = this.isr; break;
        case 7: data = this.osr; break;
      }
      data &= ones(count);
      if (count === 32) this.isr = data >>> 0;
      else if (this.shiftctrl & 0x40000) this.isr = ((this.isr >>> count) | (data << (32 - count))) >>> 0;
      else this.isr = ((this.isr << count) | data) >>> 0;
      this.isr_count = Math.min(32, this.isr_count + count);
    }
    this.in_shifted = false;
    if (this.shiftctrl & 0x10000 && this.isr_count >= this.push_threshold) {
      if (this.rx.length >= this.rx_depth) {
        this.in_shifted = true;
        this.stall_on_rx();
      } else {
        this.push();
      }
    }
  }

  do_out(argument) {
    const autopull = (this.shiftctrl & 0x20000) !== 0;
    if (autopull && this.osr_count >= this.pull_threshold) {
      if (this.tx.length === 0) return this.stall_on_tx();
      this.refill(); // which takes the cycle
      this.stall = STALL_ONE_TICK;
      return undefined;
    }
    const count = argument & 31 || 32;
    let data;
    if (count === 32) {
      data = this.osr;
      this.osr = 0;
    } else if (this.shiftctrl & 0x80000) {
      data = this.osr & ones(count);
      this.osr >>>= count;
    } else {
      data = this.osr >>> (32 - count);
      this.osr = (this.osr << count) >>> 0;
    }
    data >>>= 0;
    this.osr_count = Math.min(32, this.osr_count + count);
    if (autopull) this.refill();
    const base = this.pinctrl & 31;
    const width = (this.pinctrl >>> 20) & 63;
    switch (argument >>> 5) {
      case 0: this.pio.write_pins(base, width, data); break;
      case 1: this.x = data; break;
      case 2: this.y = data; break;
      case 4: this.pio.write_directions(base, width, data); break;
      case 5: this.jump(data & 31); break;
      case 6: this.isr = data; this.isr_count = count; break;
      case 7: this.exec_next(data & 0xffff); break;
    }
    return undefined;
  }

  jump(target) {
    this.pc = target;
    this.jumped = true;
  }

  exec_next(word) {
    this.exec = word;
    this.exec_is_new = true;
  }

  /** Autopull: a word from the FIFO where the OSR is used up. */
  refill() {
    if (this.osr_count < this.pull_threshold || this.tx.length === 0) return;
    this.osr = this.tx.shift();
    this.osr_count = 0;
    this.pio.fifo_changed();
  }

  push() {
    this.rx.push(this.isr);
    this.isr = 0;
    this.isr_count = 0;
    this.pio.fifo_changed();
  }

  stall_on_tx() {
    this.stall = STALL_TX;
    this.pio.debug |= 0x01000000 << this.index; // FDEBUG.TXSTALL
  }

  stall_on_rx() {
    this.stall = STALL_RX;
    this.pio.debug |= this.bit; // FDEBUG.RXSTALL
  }

  do_push_pull(argument) {
    const conditional = (argument & 0x40) !== 0;
    const blocking = (argument & 0x20) !== 0;
    if (argument & 0x80) {
      if (conditional && this.osr_count < this.pull_threshold) return;
      if (this.shiftctrl & 0x20000 && this.osr_count === 0) return; // autopull has done it
      if (this.tx.length > 0) {
        this.osr = this.tx.shift();
        this.osr_count = 0;
        this.pio.fifo_changed();
      } else if (blocking) {
        this.stall_on_tx();
      } else {
        this.osr = this.x;
        this.osr_count = 0;
      }
    } else {
      if (conditional && this.isr_count < this.push_threshold) return;
      if (this.rx.length < this.rx_depth) {
        this.push();
      } else if (blocking) {
        this.stall_on_rx();
      } else {
        this.pio.debug |= this.bit;
        this.isr = 0;
        this.isr_count = 0;
      }
    }
  }

  do_mov(argument, cycle) {
    let data = 0;
    switch (argument & 7) {
      case 0: data = this.rotated_inputs(cycle); break;
      case 1: data = this.x; break;
      case 2: data = this.y; break;
      case 5: data = this.status() ? 0xffffffff : 0; break;
      case 6: data = this.isr; break;
      case 7: data = this.osr; break;
    }
    const operation = (argument >>> 3) & 3;
    if (operation === 1) data = ~data >>> 0;
    else if (operation === 2) data = reverse_bits(data);
    switch (argument >>> 5) {
      case 0: this.pio.write_pins(this.pinctrl & 31, (this.pinctrl >>> 20) & 63, data); break;
      case 1: this.x = data; break;
      case 2: this.y = data; break;
      case 4: this.exec_next(data & 0xffff); break;
      case 5: this.jump(data & 31); break;
      case 6: this.isr = data; this.isr_count = 0; break;
      case 7: this.osr = data; this.osr_count = 0; break;
    }
  }

  status() {
    const level = this.execctrl & 0x10 ? this.rx.length : this.tx.length;
    return level < (this.execctrl & 15);
  }

  do_irq(argument) {
    const flag = 1 << this.irq_index(argument & 31);
    if (argument & 0x40) {
      this.pio.clear_flag(flag);
    } else if (!(argument & 0x20)) {
      this.pio.raise_flag(flag);
    } else if (!this.irq_sent) {
      this.pio.raise_flag(flag);
      this.irq_sent = true;
      this.stall = STALL_IRQ;
    } else if (this.pio.irq_flags & flag) {
      this.stall = STALL_IRQ;
    } else {
      this.irq_sent = false;
    }
  }

  do_set(argument) {
    const data = argument & 31;
    const base = (this.pinctrl >>> 5) & 31;
    const width = (this.pinctrl >>> 26) & 7;
    switch (argument >>> 5) {
      case 0: this.pio.write_pins(base, width, data); break;
      case 1: this.x = data; break;
      case 2: this.y = data; break;
      case 4: this.pio.write_directions(base, width, data); break;
    }
  }

  /** SMx_INSTR: done in the cycle after the write whatever the divider says; its delay is not kept. */
  force(word, cycle) {
    this.settle(cycle);
    this.irq_sent = false;
    this.jumps_only = false;
    this.exec = -1;
    const due = this.next;
    this.jumped = false;
    this.execute(word, cycle + 1, true);
    if (this.stall !== STALL_NONE) this.exec = word; // stays latched: EXECCTRL.EXEC_STALLED
    if (this.stall !== STALL_NONE && this.stall !== STALL_INPUT) this.next = NEVER;
    else if (this.enabled) this.next = this.divider.first_tick_from(Math.max(cycle + 2, due === NEVER ? 0 : due));
  }

  // ---- loops of jumps. A round that changes nothing but x and y, by no more than one each, and met no new input, is
  // followed by equal rounds until x or y runs out or an input changes: they are done in one go.

  look_for_loop(from, cycle, ticks_to_target) {
    const last = this.probe;
    const pin = this.reads_pin ? 1 << ((this.execctrl >>> 24) & 31) : 0;
    const same = this.jumps_only && last !== null && last.from === from && !this.compares &&
      (pin === 0 || this.pio.pins.last_input_change + 2 < last.cycle);
    this.compares = false;
    this.reads_pin = false;
    this.probe = { from, cycle, x: this.x, y: this.y };
    this.jumps_only = true;
    if (!same) return;
    const dx = (last.x - this.x) >>> 0;
    const dy = (last.y - this.y) >>> 0;
    if (dx > 1 || dy > 1) return;
    const rounds = Math.min(dx ? this.x : NEVER, dy ? this.y : NEVER) - 2;
    if (rounds < 1) return;
    this.skip_loop({ dx, dy, pin, count: rounds, target: this.pc,
      round_ticks: this.divider.ticks_between(last.cycle, cycle) }, cycle, ticks_to_target);
  }

  skip_loop(loop, cycle, ticks_to_target) {
    this.loop = loop;
    this.divider.tick = cycle;
    this.divider.move(ticks_to_target); // the first round starts where it would have gone on
    this.next = loop.count === NEVER ? NEVER : this.divider.cycle_of(loop.count * loop.round_ticks);
  }

  /** Leaves the skipped loop after so many rounds. */
  end_loop(rounds) {
    const { loop } = this;
    this.loop = null;
    this.x = (this.x - loop.dx * rounds) >>> 0;
    this.y = (this.y - loop.dy * rounds) >>> 0;
    this.pc = loop.target;
    this.next = this.divider.move(rounds * loop.round_ticks);
    this.jumps_only = false;
    this.probe = null;
  }

  /** Makes its state that at the end of the given cycle, where it is in a loop that is being skipped. */
  settle(cycle) {
    if (this.loop === null) return;
    const { round_ticks, count } = this.loop;
    const rounds = Math.min(count, Math.floor(this.divider.ticks_until(cycle) / round_ticks));
    this.end_loop(rounds);
    while (this.next <= cycle && this.loop === null) this.step(this.next);
    if (this.loop !== null) this.end_loop(0);
  }
}
