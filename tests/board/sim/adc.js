// SPDX-License-Identifier: MIT
// The analogue-digital converter: 96 cycles of its 48 MHz a conversion, free running by its divider, FIFO of four.
import { Block } from "./block.js";

const IRQ_ADC_FIFO = 22;
const CYCLES_PER_TICK = 125 / 48; // of the processor's clock, for one of clk_adc
const CONVERSION_TICKS = 96;
const DEPTH = 4;
const FULL_SCALE_MV = 3300;

export class Adc extends Block {
  constructor(chip, clock) {
    super(chip, "ADC");
    this.start_alarm = clock.createAlarm(() => this.begin());
    this.done_alarm = clock.createAlarm(() => this.finish());
    this.reset();
  }

  reset() {
    this.start_alarm.cancel();
    this.done_alarm.cancel();
    this.cs = 0;
    this.fcs = 0; // EN, SHIFT, ERR, DREQ_EN, THRESH
    this.sticky = 0; // FCS.OVER and UNDER
    this.div = 0;
    this.result = 0;
    this.fifo = [];
    this.inte = 0;
    this.intf = 0;
    this.busy = false;
    this.start_tick = 0; // of the last conversion, in clk_adc ticks that may be broken
    this.update_irq();
  }

  get channel() {
    return (this.cs >>> 12) & 7;
  }

  // ---- conversions

  begin() {
    if (!(this.cs & 1) || this.busy) return;
    if (!this.chip.adc_clock_runs()) return;
    this.busy = true;
    this.start_tick = this.chip.queue.now / CYCLES_PER_TICK;
    this.code = this.convert(this.chip.adc_input_mv(this.channel));
    this.done_alarm.at(this.chip.queue.now + Math.ceil(CONVERSION_TICKS * CYCLES_PER_TICK));
    if (this.cs & 8) {
      const ticks = this.div >>> 8 ? 1 + this.div / 256 : 0;
      this.due = (this.due ?? this.start_tick) + Math.max(CONVERSION_TICKS, ticks);
      if (ticks > CONVERSION_TICKS) this.start_alarm.at(Math.round(this.due * CYCLES_PER_TICK));
    }
  }

  convert(input_mv) {
    return Math.min(4095, Math.max(0, Math.floor((input_mv / FULL_SCALE_MV) * 4096)));
  }

  finish() {
    this.busy = false;
    this.result = this.code;
    if (this.fcs & 1) {
      if (this.fifo.length >= DEPTH) this.sticky |= 1 << 11;
      else this.fifo.push(this.fcs & 2 ? this.code >>> 4 : this.code);
      this.update_irq();
    }
    this.next_channel();
    if (this.cs & 8 && !this.start_alarm.scheduled) this.begin();
  }

  next_channel() {
    const robin = (this.cs >>> 16) & 0x1f;
    if (robin === 0) return;
    let channel = this.channel;
    do channel = (channel + 1) % 5;
    while (!(robin & (1 << channel)));
    this.cs = (this.cs & ~0x7000) | (channel << 12);
  }

  // ---- registers

  update_irq() {
    this.chip.core.setInterrupt(IRQ_ADC_FIFO, ((this.raw_interrupt() & this.inte) | this.intf) !== 0);
  }

  raw_interrupt() {
    return this.fifo.length >= ((this.fcs >>> 24) & 15) ? 1 : 0;
  }

  read(offset) {
    switch (offset) {
      case 0x00: return this.cs | (this.cs & 1 && !this.busy ? 1 << 8 : 0);
      case 0x04: return this.result;
      case 0x08:
        return this.fcs | this.sticky | (this.fifo.length << 16) | (this.fifo.length === DEPTH ? 1 << 9 : 0) |
          (this.fifo.length === 0 ? 1 << 8 : 0);
      case 0x0c: return this.read_fifo();
      case 0x10: return this.div;
      case 0x14: return this.raw_interrupt();
      case 0x18: return this.inte;
      case 0x1c: return this.intf;
      case 0x20: return (this.raw_interrupt() & this.inte) | this.intf;
      default: return this.unknown("read", offset);
    }
  }

  read_fifo() {
    if (this.fifo.length === 0) {
      this.sticky |= 1 << 10;
      return 0;
    }
    const code = this.fifo.shift();
    this.update_irq();
    return code;
  }

  write(offset, value) {
    switch (offset) {
      case 0x00: this.write_control(value); break;
      case 0x08:
        this.sticky &= ~this.raw;
        this.fcs = value & 0x0f00000f;
        break;
      case 0x0c: break;
      case 0x10: this.div = value & 0xffffff; break;
      case 0x18: this.inte = value & 1; break;
      case 0x1c: this.intf = value & 1; break;
      default: this.unknown("write", offset);
    }
    this.update_irq();
  }

  write_control(value) {
    const many_before = this.cs & 8;
    this.cs = value & 0x1f700b & ~4;
    if (!(this.cs & 8)) this.start_alarm.cancel();
    if (!(this.cs & 1) || this.busy) return;
    if (value & 4 || (this.cs & 8 && !many_before)) {
      this.due = undefined;
      this.begin();
    }
  }
}
