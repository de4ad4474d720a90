// SPDX-License-Identifier: MIT
// The RP2040: joins rp2040js' processor and quiet peripherals with our own blocks, boots, resets, and runs all of it by
// cycles of 8 ns. clk_sys is taken to be 125 MHz from the first cycle on.
import { RP2040 } from "rp2040js";
import { Adc } from "./adc.js";
import { Block, Gate } from "./block.js";
import { ChipClock, CYCLE_NS, EventQueue } from "./event_queue.js";
import { Pins } from "./pins.js";
import { Pio } from "./pio.js";
import { PrivateBlock } from "./ppb.js";
import { BusFault, Processor } from "./processor.js";
import { boots, call_rom, make_rom } from "./rom.js";
import { Flash, IoQspi, Ssi } from "./ssi.js";
import { Pll, Regulator, Resets, RingOscillator } from "./system_blocks.js";
import { Timer, Watchdog } from "./timer.js";
import { UsbPort } from "./usb_port.js";

const RAM_BYTES = 264 * 1024;
const BOOT2_ADDRESS = 0x20041f00;
const PIO_IRQS = [7, 9];
const RESET_BIT = { adc: 0, busctrl: 1, i2c0: 3, i2c1: 4, io_bank0: 5, io_qspi: 6, pads_bank0: 8, pads_qspi: 9,
  pio0: 10, pio1: 11, pll_sys: 12, pll_usb: 13, pwm: 14, rtc: 15, spi0: 16, spi1: 17, syscfg: 18, sysinfo: 19,
  tbman: 20, timer: 21, uart0: 22, uart1: 23, usb: 24 };

/** Blocks that nothing here stands for. */
class Missing extends Block {
  read(offset) {
    return this.unknown("read", offset);
  }

  write(offset) {
    this.unknown("write", offset);
  }
}

export class Chip {
  /** unique_id: eight bytes of the flash; seed: of ROSC's random bit. */
  constructor({ unique_id = [0xe6, 0x60, 0x58, 0x38, 0x83, 0x12, 0x34, 0x56], seed = 1 } = {}) {
    this.queue = new EventQueue();
    this.flash = new Flash(unique_id);
    this.rom = make_rom();
    this.sram = new Uint8Array(RAM_BYTES);
    this.seed = seed;
    this.complaints = new Map(); // what firmware should not do -> how often
    this.adc_inputs = [0, 0, 0, 0, 706]; // millivolts, or functions of the time in ns
    this.on_start = () => {}; // called when the chip starts or loses power: (cause)
    this.on_exception = null;
    this.pio = [];
    this.state = "off"; // "running", "bootsel"
    this.clock = new ChipClock(this.queue);
    this.pins = new Pins(this);
    this.due_reset = null;
    this.resets_seen = []; // { cycle, cause }
    this.build_life("power");
    this.state = "off";
  }

  // ---- life

  power_on() {
    this.sram.fill(0);
    this.start("power");
  }

  /** All pins float at once; flash keeps. */
  power_off() {
    this.build_life("power");
    this.core.stopped = true;
    this.state = "off";
    this.on_start("off");
  }

  /** Lets the chip start anew: after power-up, the watchdog, the RUN pin; or into the ROM's USB boot. */
  start(cause) {
    this.resets_seen.push({ cycle: this.queue.now, cause });
    if (this.watchdog.scratch[4] === 0xb007c0d3 && cause !== "power") {
      this.complain("WATCHDOG_SCRATCH4 asks the ROM for a start elsewhere, which is not in the model");
    }
    this.build_life(cause);
    if (cause === "bootsel" || !boots(this.flash.bytes)) {
      this.state = "bootsel";
      this.core.stopped = true;
    } else {
      this.state = "running";
      this.sram.set(this.flash.bytes.subarray(0, 256), BOOT2_ADDRESS - 0x20000000);
      this.core.start(BOOT2_ADDRESS, BOOT2_ADDRESS);
    }
    this.on_start(this.state === "bootsel" ? "bootsel" : cause);
  }

  /** Ends this life after the instruction that is being done. */
  request_reset(cause) {
    this.due_reset = cause;
    this.queue.limit = 0;
  }

  /** The watchdog's time is up (reason 1) or it was triggered (2); resets what PSM and RESETS select. */
  watchdog_fires(reason) {
    const needed = (1 << 15) | (1 << 3); // proc0 and resets: together they take all else with them
    if ((this.rp.peripherals[0x40010].readUint32(8) & needed) !== needed) {
      this.complain("the watchdog fires, but PSM_WDSEL does not select the chip: nothing is reset");
      return;
    }
    this.watchdog.reason = reason;
    this.request_reset("watchdog");
  }

  build_life(cause) {
    const before = cause === "power" ? null : this.watchdog;
    const { now } = this.queue;
    this.clock.drop_alarms();
    this.clock = new ChipClock(this.queue);
    this.pio = [];
    const rp = new RP2040(this.clock);
    this.rp = rp;
    rp.sram = this.sram;
    rp.logger = this.logger();
    this.core = new Processor(rp, this);
    this.core.cycles = now;
    rp.core = this.core;
    rp.onBreak = (number) => this.breakpoint(number);
    rp.updateClocks = () => this.clocks_changed();
    this.sio = rp.sio;
    this.pins.reset();
    rp.gpio = Array.from({ length: 30 }, (_, pin) => this.pin_for_stock(pin));
    Object.defineProperty(rp, "gpioValues", { get: () => this.pins.inputs });
    this.resets = new Resets(this);
    this.watchdog = new Watchdog(this, this.clock, before);
    this.timer = new Timer(this, this.clock);
    this.ppb = new PrivateBlock(this, this.core, this.clock);
    rp.ppb = this.ppb;
    this.adc = new Adc(this, this.clock);
    this.ssi = new Ssi(this, this.flash);
    this.io_qspi = new IoQspi(this, this.ssi);
    for (const index of [0, 1]) this.pio.push(new Pio(this, index, PIO_IRQS[index]));
    this.usb = new UsbPort(this);
    this.pll_sys = new Pll(this, rp.pllSys, "PLL_SYS");
    this.pll_usb = new Pll(this, rp.pllUsb, "PLL_USB");
    this.fill_bus(rp, cause);
  }

  fill_bus(rp, cause) {
    const stock = { ...rp.peripherals };
    const gate = (name, inner) => {
      if (inner.reset) this.resets.gates.set(RESET_BIT[name], () => inner.reset());
      return new Gate(this, inner, RESET_BIT[name], name.toUpperCase());
    };
    rp.peripherals = {
      0x18000: this.ssi,
      0x40000: gate("sysinfo", stock[0x40000]),
      0x40004: gate("syscfg", stock[0x40004]),
      0x40008: stock[0x40008], // CLOCKS
      0x4000c: this.resets,
      0x40010: stock[0x40010], // PSM
      0x40014: gate("io_bank0", this.pins.io),
      0x40018: gate("io_qspi", this.io_qspi),
      0x4001c: gate("pads_bank0", this.pins.pads),
      0x40020: gate("pads_qspi", stock[0x40020]),
      0x40024: stock[0x40024], // XOSC
      0x40028: gate("pll_sys", this.pll_sys),
      0x4002c: gate("pll_usb", this.pll_usb),
      0x40030: gate("busctrl", stock[0x40030]),
      0x40034: gate("uart0", stock[0x40034]),
      0x40038: gate("uart1", stock[0x40038]),
      0x4003c: gate("spi0", stock[0x4003c]),
      0x40040: gate("spi1", stock[0x40040]),
      0x40044: gate("i2c0", stock[0x40044]),
      0x40048: gate("i2c1", stock[0x40048]),
      0x4004c: gate("adc", this.adc),
      0x40050: gate("pwm", stock[0x40050]),
      0x40054: gate("timer", this.timer),
      0x40058: this.watchdog,
      0x4005c: gate("rtc", stock[0x4005c]),
      0x40060: new RingOscillator(this, this.seed),
      0x40064: new Regulator(this, cause),
      0x4006c: gate("tbman", stock[0x4006c]),
      0x50000: new Missing(this, "DMA"),
      0x50110: gate("usb", this.usb),
      0x50200: gate("pio0", this.pio[0]),
      0x50300: gate("pio1", this.pio[1]),
    };
  }

  // ---- what rp2040js asks for

  logger() {
    const complain = (name, text) => this.complain(`${name}: ${text}`);
    return { debug() {}, info() {}, warn: complain, error: complain };
  }

  pin_for_stock(pin) {
    const { pins, queue } = this;
    return {
      checkForUpdates: () => pins.update(1 << pin, queue.now + 1),
      get inputValue() {
        return ((pins.inputs >>> pin) & 1) !== 0;
      },
    };
  }

  breakpoint(number) {
    const address = (this.core.PC - 2) >>> 0;
    if (address < 0x4000) call_rom(this, number);
    else this.core.hard_fault(`breakpoint or undefined instruction ${number} at pc 0x${address.toString(16)}`);
  }

  // ---- clocks that blocks depend on

  clocks_changed() {
    if (!this.timer) return;
    this.watchdog.change(() => {});
    this.timer.change(() => {
      this.timer.running = this.watchdog.tick_runs;
    });
  }

  clock_is_48_mhz(control, name) {
    const runs = (control & 0x800) !== 0 && ((control >>> 5) & 7) === 0 && this.rp.pllUsb.frequency === 48e6;
    if (!runs) this.complain(`${name} is used, but its clock is not enabled at 48 MHz of PLL_USB`);
    return runs;
  }

  adc_clock_runs() {
    return this.clock_is_48_mhz(this.rp.clocks.adcCtrl, "ADC");
  }

  usb_clock_runs() {
    return this.clock_is_48_mhz(this.rp.clocks.usbCtrl, "USB");
  }

  adc_input_mv(channel) {
    const input = this.adc_inputs[channel] ?? 0;
    return typeof input === "function" ? input(this.queue.now * CYCLE_NS) : input;
  }

  // ---- faults for tests

  /** The processor stands still from now on; everything else goes on. */
  stop_processor() {
    this.core.stopped = true;
    this.core.waiting = true;
  }

  /** The processor goes on, but takes no interrupt any more. */
  mask_interrupts() {
    this.core.most_urgent = () => 0;
  }

  complain(text) {
    this.complaints.set(text, (this.complaints.get(text) ?? 0) + 1);
  }

  // ---- running

  get cycle() {
    return Math.max(this.queue.now, this.core.cycles);
  }

  /** Runs up to that cycle; the processor may end its last instruction a little later. */
  run_until(end) {
    const { queue } = this;
    for (;;) {
      if (this.due_reset !== null) this.do_due_reset();
      const { core } = this;
      const [pio0, pio1] = this.pio;
      const next = Math.min(queue.next, pio0.next, pio1.next);
      if (next <= core.cycles && next <= end) {
        if (pio0.next === next) pio0.step();
        else if (pio1.next === next) pio1.step();
        else queue.run_first();
      } else if (core.cycles >= end) {
        break;
      } else if (core.waiting || core.stopped) {
        if (!core.wake_if_due()) core.cycles = Math.min(next, end);
      } else {
        queue.limit = Math.min(next, end);
        this.run_processor(core);
      }
    }
    queue.now = Math.max(queue.now, end);
  }

  run_processor(core) {
    try {
      core.run(this.queue);
    } catch (error) {
      if (!(error instanceof BusFault)) throw error;
      core.hard_fault(error.message);
    }
  }

  do_due_reset() {
    const cause = this.due_reset;
    this.due_reset = null;
    this.queue.now = Math.max(this.queue.now, this.core.cycles);
    this.start(cause);
  }
}
