// SPDX-License-Identifier: MIT
// The sync board on a bench: chip, host, wires, supply. What tests drive; see README.md.
import { readFileSync } from "node:fs";
import { Chip } from "./chip.js";
import { CYCLE_NS } from "./event_queue.js";
import { HidDevice, run_script } from "./hid_device.js";
import { UsbHost } from "./usb_host.js";

/** Waits of enumeration in milliseconds, shorter than a real host's so that tests are quick. */
const QUICK = { settle_ms: 1, reset_ms: 3, recovery_ms: 2, address: 5 };
const UF2_BLOCK = 512, UF2_MAGIC = 0x0a324655, FLASH_BASE = 0x10000000;

/** Bytes for the flash from a raw image or a UF2 file. */
export function flash_image(path) {
  const file = readFileSync(path);
  if (file.length < 4 || file.readUInt32LE(0) !== UF2_MAGIC) return file;
  const pieces = [];
  for (let at = 0; at < file.length; at += UF2_BLOCK) {
    const offset = file.readUInt32LE(at + 12) - FLASH_BASE;
    pieces.push({ offset, data: file.subarray(at + 32, at + 32 + file.readUInt32LE(at + 16)) });
  }
  const image = Buffer.alloc(Math.max(...pieces.map(({ offset, data }) => offset + data.length)), 0xff);
  for (const { offset, data } of pieces) data.copy(image, offset);
  return image;
}

export class Board {
  /** A board without firmware and without power. `plugged`: whether its USB cable is in a host. */
  constructor({ plugged = true, enumerates = true, ...chip_options } = {}) {
    this.chip = new Chip(chip_options);
    this.plugged = plugged;
    this.enumerates = enumerates;
    this.device = undefined; // HidDevice of the present attachment
    this.attachments = []; // all of them
    this.failures = []; // errors of enumeration
    this.host = new UsbHost(this.chip.queue, () => (this.plugged ? this.chip.usb : undefined));
    this.host.on_attach = () => this.attached();
    this.host.on_detach = () => {
      this.device = undefined;
    };
    this.chip.on_start = () => this.chip_started();
  }

  /** A powered board with this firmware (raw image or UF2), run until it can be used as a HID device. */
  static boot(path, options = {}) {
    const { timeout_ms = 1000, watch = [], ...rest } = options;
    const board = new Board(rest);
    board.chip.flash.load(flash_image(path));
    for (const pin of watch) board.chip.pins.watch(pin);
    board.chip.power_on();
    if (board.enumerates && board.plugged) board.run_until_ready(timeout_ms);
    return board;
  }

  chip_started() {
    const { usb } = this.chip;
    this.host.pull_up_changed();
    usb.on_attach_change = () => this.host.pull_up_changed();
    this.host.pull_up_changed();
  }

  attached() {
    const { sysFreq } = this.chip.rp.clocks;
    if (sysFreq !== 125e6) this.chip.complain(`clk_sys is set to ${sysFreq} Hz, but the model counts 125 MHz`);
    if (this.enumerates) this.enumerate();
  }

  /** Begins to enumerate what is attached, also once more, as a host does that has reset the bus. */
  enumerate() {
    const device = new HidDevice(this.host);
    this.device = device;
    this.attachments.push(device);
    run_script(this.host, device.enumerate(QUICK), (error) => {
      device.error = error;
      this.failures.push(error);
    });
  }

  // ---- time

  get cycle() {
    return this.chip.queue.now;
  }

  get time_ns() {
    return this.cycle * CYCLE_NS;
  }

  run_ns(duration_ns) {
    this.chip.run_until(this.cycle + Math.round(duration_ns / CYCLE_NS));
  }

  run_us(duration_us) {
    this.run_ns(duration_us * 1e3);
  }

  run_ms(duration_ms) {
    this.run_ns(duration_ms * 1e6);
  }

  /** Runs until the condition holds, looking every step_us; throws after timeout_ms of simulated time. */
  run_until(condition, timeout_ms = 1000, step_us = 20) {
    const end = this.cycle + timeout_ms * 125000;
    while (!condition()) {
      if (this.cycle >= end) throw new Error(`not so after ${timeout_ms} ms: ${condition}${this.trouble()}`);
      this.run_us(step_us);
    }
  }

  run_until_ready(timeout_ms = 1000) {
    const end = this.cycle + timeout_ms * 125000;
    while (this.device?.ready !== true) {
      if (this.cycle >= end) throw new Error(`no HID device after ${timeout_ms} ms${this.trouble()}`);
      this.run_us(100);
    }
  }

  /** Why something may not work, for messages. */
  trouble() {
    const lines = [`state ${this.chip.state}, pc 0x${this.chip.core.PC.toString(16)}`,
      this.host.connected ? "attached" : "not attached", ...this.failures.map((error) => error.message),
      ...this.chip.complaints.keys()];
    return `\n  ${lines.join("\n  ")}`;
  }

  /** Calls back at a time of the simulation. */
  at_ns(time_ns, callback) {
    this.chip.queue.at(Math.round(time_ns / CYCLE_NS), callback);
  }

  // ---- USB

  get reports() {
    return this.device?.reports ?? [];
  }

  /** Runs until the transfer has ended; its data, or its error thrown. */
  finish(transfer, step_us = 5) {
    while (!transfer.done) this.run_us(step_us);
    if (transfer.error) throw transfer.error;
    return transfer.data;
  }

  need_device() {
    if (this.device?.ready !== true) throw new Error(`no HID device${this.trouble()}`);
    return this.device;
  }

  get_feature(id, length = 64) {
    return this.finish(this.need_device().start_get_feature(id, length));
  }

  set_feature(bytes) {
    this.finish(this.need_device().start_set_feature(bytes));
  }

  /** Keeps GET_REPORTs of one feature coming, so many a second or as many as fit; returns their count and a stop(). */
  hammer(id, rate_hz, length = 64) {
    const state = { done: 0, failed: 0, late: 0, stopped: false, stop: () => { state.stopped = true; } };
    const period = 125e6 / rate_hz;
    let due = this.cycle;
    const send = () => {
      if (state.stopped || this.device?.ready !== true) return;
      this.device.start_get_feature(id, length, (transfer) => {
        if (transfer.error) state.failed++;
        else state.done++;
        due += period;
        if (due < this.cycle) {
          state.late++;
          due = this.cycle;
        }
        this.chip.queue.at(Math.round(due), send);
      });
    };
    send();
    return state;
  }

  unplug() {
    this.plugged = false;
    this.host.pull_up_changed();
  }

  plug() {
    this.plugged = true;
    this.host.pull_up_changed();
  }

  // ---- pins and supply

  watch(...pins) {
    for (const pin of pins) this.chip.pins.watch(pin);
  }

  /** Edges of a watched pin: [{ cycle, time_ns, level }]; the first is the level when watching began. */
  edges(pin) {
    return (this.chip.pins.log.get(pin) ?? []).map((entry) => {
      const cycle = Math.floor(entry / 2);
      return { cycle, time_ns: cycle * CYCLE_NS, level: entry % 2 };
    });
  }

  level(pin) {
    return this.chip.pins.read(pin);
  }

  /** Drives an input from outside; undefined lets go of it. */
  drive(pin, level) {
    this.chip.pins.drive_pin(pin, level);
  }

  connect(from, to) {
    this.chip.pins.connect(from, to);
  }

  /** Millivolts at an ADC pin: a number, or a function of the time in ns. */
  adc_mv(channel, input) {
    this.chip.adc_inputs[channel] = input;
  }

  // ---- faults

  power_cycle(off_ms = 10) {
    this.chip.power_off();
    this.run_ms(off_ms);
    this.chip.power_on();
  }

  stop_processor() {
    this.chip.stop_processor();
  }

  mask_interrupts() {
    this.chip.mask_interrupts();
  }

  /** What the firmware did that it should not: [[text, how often]]. */
  get complaints() {
    return [...this.chip.complaints];
  }
}
