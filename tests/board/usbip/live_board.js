// SPDX-License-Identifier: MIT
// A board that runs in real time and is a USB device to whoever imports it: the firmware's, or the ROM's in BOOTSEL
// mode.
import { Board, flash_image } from "../sim/board.js";
import { get_descriptor, run_script, setup_packet } from "../sim/hid_device.js";
import { Picoboot } from "../sim/picoboot.js";

const DEVICE = 1, CONFIGURATION = 2;
const ADDRESS = 5;
const SLIP_NS = 20e6; // further behind than this it does not catch up
const STEP_NS = 250e3;
const AHEAD_NS = 200e3; // of real time, where a request waits for its answer
const BOOTSEL_MS = 100; // from the reset until the ROM shows its device
const ERRNO = { STALL: -32, NO_ANSWER: -71, TIMEOUT: -110, DETACHED: -108, RESET: -108 };

/** The firmware's device, over the token bus. */
class FirmwareDevice {
  constructor(host) {
    this.host = host;
    this.transfers = new Map(); // on_done -> transfer
  }

  /** Resets the bus, gives the device an address and reads what an importer is told. */
  *prepare() {
    yield { wait_ms: 5 };
    yield { reset_ms: 10 };
    yield { wait_ms: 5 };
    this.host.max_packet_0 = 64;
    this.device_descriptor = yield { setup: get_descriptor(DEVICE, 0, 0, 18) };
    yield { setup: setup_packet(0, 5, ADDRESS, 0, 0) };
    this.host.address = ADDRESS;
    yield { wait_ms: 2 };
    this.configuration = yield { setup: get_descriptor(CONFIGURATION, 0, 0, 255) };
  }

  submit(request, on_done) {
    let ended_already = false;
    const ended = (transfer) => {
      ended_already = true;
      this.transfers.delete(on_done);
      on_done(transfer.error ? ERRNO[transfer.error.code] ?? -71 : 0, transfer.data);
    };
    if (request.endpoint !== 0 && !request.to_host) {
      on_done(-71); // the firmware has no OUT endpoint but 0
      return;
    }
    const interval_ms = Math.max(1, request.interval);
    const transfer = request.endpoint === 0 ? this.host.control(request.setup, request.data, ended)
                                            : this.host.interrupt_in(request.endpoint, interval_ms, ended);
    if (!ended_already) this.transfers.set(on_done, transfer);
  }

  cancel(on_done) {
    const transfer = this.transfers.get(on_done);
    if (transfer !== undefined) this.host.cancel(transfer);
    this.transfers.delete(on_done);
  }
}

export class LiveBoard {
  constructor(options = {}) {
    this.board = new Board({ enumerates: false, ...options });
    this.device = undefined; // what can be imported now
    this.waiting = []; // callbacks that wait for a device
    this.on_gone = () => {}; // the device that was imported is no more
    this.slips = 0;
    this.hurries = false;
    this.failures = [];
    const { host, chip } = this.board;
    host.on_attach = () => this.came(new FirmwareDevice(host));
    host.on_detach = () => this.went();
    const started = chip.on_start;
    chip.on_start = (cause) => {
      if (this.device instanceof Picoboot) this.went();
      started(cause);
      if (cause === "bootsel") this.show_bootsel();
    };
  }

  show_bootsel() {
    const { chip } = this.board;
    chip.queue.at(chip.queue.now + BOOTSEL_MS * 125000, () => {
      if (chip.state !== "bootsel" || !this.board.plugged || this.device !== undefined) return;
      this.came(new Picoboot(chip, () => chip.request_reset("reboot")));
    });
  }

  flash(path) {
    this.board.chip.flash.bytes.fill(0xff);
    this.board.chip.flash.load(flash_image(path));
  }

  came(device) {
    this.device = device;
    for (const callback of this.waiting.splice(0)) this.prepare(callback);
  }

  went() {
    this.device = undefined;
    this.on_gone();
  }

  unplug() {
    this.board.unplug();
    if (this.device instanceof Picoboot) this.went();
  }

  plug() {
    this.board.plug();
    if (this.board.chip.state === "bootsel") this.show_bootsel();
  }

  /** Calls back with a device that has been reset, now or when there is one. */
  when_ready(callback) {
    if (this.device === undefined) this.waiting.push(callback);
    else this.prepare(callback);
  }

  prepare(callback) {
    const { device } = this;
    if (device instanceof Picoboot) {
      device.reset_interface();
      callback(device);
      return;
    }
    const then_ready = function* then_ready() {
      yield* device.prepare();
      callback(device);
    };
    run_script(this.board.host, then_ready(), (error) => {
      if (this.failures.length < 20) this.failures.push(error.message);
      if (this.device === device) this.prepare(callback);
      else this.when_ready(callback);
    });
  }

  // ---- real time

  start() {
    this.offset_ns = performance.now() * 1e6 - this.board.time_ns;
    this.timer = setInterval(() => this.keep_up(), 1);
  }

  stop() {
    clearInterval(this.timer);
  }

  /** Runs up to now, or a little ahead so that a request is answered at once. Where this machine was too slow for that,
   * simulated time is late for good, and that is counted. */
  keep_up(ahead_ns = 0) {
    const now_ns = performance.now() * 1e6;
    let target_ns = now_ns - this.offset_ns + ahead_ns;
    if (target_ns - this.board.time_ns > SLIP_NS) {
      this.slips++;
      this.offset_ns = now_ns - this.board.time_ns - STEP_NS;
      target_ns = this.board.time_ns + STEP_NS;
    }
    const { board } = this;
    while (board.time_ns < target_ns) board.run_ns(Math.min(STEP_NS, target_ns - board.time_ns + 8));
  }

  /** Keeps up without waiting for the timer while control transfers are under way. */
  hurry() {
    this.keep_up(AHEAD_NS);
    if (this.hurries || this.board.host.controls.length === 0) return;
    this.hurries = true;
    setImmediate(() => {
      this.hurries = false;
      this.hurry();
    });
  }
}
