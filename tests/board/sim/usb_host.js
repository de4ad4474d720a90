// SPDX-License-Identifier: MIT
// A host at the other end of the cable: tokens at the bus' own times (12 Mbit/s), frames of 1 ms, retries, enumeration.
import { CYCLE_NS } from "./event_queue.js";

const CYCLES_PER_MS = 125000;
const CYCLES_PER_BIT = 125 / 12;
// Bits of packets with sync, check and end; 6 between packets where the direction turns, 2 where not. No bit stuffing.
const TOKEN_BITS = 35, HANDSHAKE_BITS = 19, TURN_BITS = 6, GAP_BITS = 2;
const RETRIES = 3;
const CONTROL_TIMEOUT = 5000 * CYCLES_PER_MS;

function data_bits(length) {
  return 35 + 8 * length;
}

function cycles(bits) {
  return Math.ceil(bits * CYCLES_PER_BIT);
}

// With this less left of a frame no transaction is begun in it.
const LONGEST_TRANSACTION = cycles(TOKEN_BITS + data_bits(64) + HANDSHAKE_BITS + 2 * TURN_BITS + 60);

/** A transfer that failed: `code` is "STALL", "TIMEOUT", "NO_ANSWER" or "DETACHED". */
export class UsbError extends Error {
  constructor(code, what) {
    super(`${what}: ${code}`);
    this.code = code;
  }
}

/** One transfer under way; `done` is set with `data` or `error`. */
class Transfer {
  constructor(what, fields, on_done) {
    this.what = what;
    this.done = false;
    this.data = undefined;
    this.error = undefined;
    this.on_done = on_done;
    this.retries = 0;
    Object.assign(this, fields);
  }

  end(error, data) {
    if (this.done) return;
    this.done = true;
    this.error = error;
    this.data = data;
    if (this.on_done) this.on_done(this);
  }
}

export class UsbHost {
  /** `port()` gives the device controller of the moment, or undefined; `queue` is the chip's event queue. */
  constructor(queue, port) {
    this.queue = queue;
    this.port = port;
    this.frame_alarm = queue.create_alarm(() => this.start_frame());
    this.bus_alarm = queue.create_alarm(() => this.next_step());
    this.on_attach = () => {};
    this.on_detach = () => {};
    this.max_packet_0 = 64;
    this.totals = { transactions: 0, naks: 0, toggle_errors: 0, no_answers: 0, frames: 0, controls: 0 };
    this.faults = { lose_ack: 0, corrupt_toggle: 0, lose_data: 0 }; // how many of the next ones
    this.connected = false;
    this.drop_all("DETACHED");
    this.active = false; // frames run
    this.frame = 0;
    this.frame_start = 0;
    this.free_at = 0;
  }

  drop_all(code) {
    const all = [...(this.controls ?? []), ...(this.interrupts ?? [])];
    this.address = 0;
    this.toggles = new Map(); // endpoint -> DATA that is expected next
    this.controls = []; // queue of endpoint 0; the first is under way
    this.interrupts = []; // IN transfers that are polled
    this.due = [];
    this.step = null; // what the bus does next
    for (const transfer of all) transfer.end(new UsbError(code, transfer.what));
  }

  // ---- cable

  /** The pull-up has come or gone. */
  pull_up_changed() {
    const attached = this.port()?.attached === true;
    if (attached === this.connected) return;
    this.connected = attached;
    if (attached) {
      this.on_attach();
    } else {
      this.stop_frames();
      this.bus_alarm.cancel();
      this.drop_all("DETACHED");
      this.on_detach();
    }
  }

  /** Holds the bus in reset for so long, then frames run again. */
  reset_bus(duration_ms, on_done) {
    this.stop_frames();
    this.bus_alarm.cancel();
    this.drop_all("RESET");
    this.port().bus_reset();
    this.later(duration_ms * CYCLES_PER_MS, () => {
      this.run_frames();
      on_done();
    });
  }

  run_frames() {
    this.active = true;
    this.start_frame();
  }

  stop_frames() {
    this.active = false;
    this.frame_alarm.cancel();
  }

  /** No frames for 3 ms, which the device sees; transfers wait. */
  suspend() {
    this.stop_frames();
    this.later(3 * CYCLES_PER_MS, () => this.port()?.suspend());
  }

  resume() {
    this.port()?.resume();
    this.later(20 * CYCLES_PER_MS, () => this.run_frames());
  }

  later(duration_cycles, callback) {
    this.queue.at(this.queue.now + Math.round(duration_cycles), callback);
  }

  // ---- transfers

  /** Queues a control transfer. setup: 8 bytes; data: what goes out. Calls on_done(transfer) at its end. */
  control(setup, data, on_done) {
    const length = setup[6] | (setup[7] << 8);
    const to_host = (setup[0] & 0x80) !== 0;
    const what = `control transfer ${Array.from(setup, (byte) => byte.toString(16).padStart(2, "0")).join(" ")}`;
    const transfer = new Transfer(what, { setup, to_host, length, out: data ?? new Uint8Array(0), stage: "setup",
      received: [], toggle: 1, started: this.queue.now }, on_done);
    if (!this.connected) {
      transfer.end(new UsbError("DETACHED", what));
    } else {
      this.controls.push(transfer);
      this.work();
    }
    return transfer;
  }

  /** Waits for a packet of an interrupt endpoint, asked for once every interval_ms. */
  interrupt_in(endpoint, interval_ms, on_done) {
    const transfer = new Transfer(`interrupt IN ${endpoint}`, { endpoint, interval_ms }, on_done);
    if (this.connected) this.interrupts.push(transfer);
    else transfer.end(new UsbError("DETACHED", transfer.what));
    return transfer;
  }

  /** Takes back a transfer that has not ended; it is not called back. */
  cancel(transfer) {
    transfer.on_done = null;
    transfer.done = true;
    this.interrupts = this.interrupts.filter((other) => other !== transfer);
    this.controls = this.controls.filter((other) => other !== transfer);
  }

  // ---- frames and transactions

  start_frame() {
    if (!this.active) return;
    this.frame++;
    this.totals.frames++;
    this.frame_start = this.queue.now;
    this.frame_alarm.at(this.frame_start + CYCLES_PER_MS);
    this.port()?.start_of_frame(this.frame);
    this.due = this.interrupts.filter((transfer) => this.frame % transfer.interval_ms === 0);
    this.free_at = Math.max(this.free_at, this.frame_start + cycles(TOKEN_BITS + GAP_BITS));
    this.work();
  }

  /** Starts the next transaction, if the bus is free and the frame has room for it. */
  work() {
    if (!this.active || this.step !== null) return;
    const transfer = this.due[0] ?? this.controls[0];
    if (transfer === undefined) return;
    const start = Math.max(this.queue.now, this.free_at);
    if (this.frame_start + CYCLES_PER_MS - start < LONGEST_TRANSACTION) return;
    this.step = () => this.begin(transfer);
    this.bus_alarm.at(start);
  }

  /** The bus has come to the end of a packet; where nothing follows in this transaction, the next one starts. */
  next_step() {
    const { step } = this;
    this.step = null;
    step();
    if (this.step !== null) return;
    this.free_at = this.queue.now;
    this.work();
  }

  /** The bus is busy for so many bits, then `step` is done. */
  occupy(bits, step) {
    this.step = step;
    this.bus_alarm.at(this.queue.now + cycles(bits));
  }

  begin(transfer) {
    if (this.due[0] === transfer) this.due.shift();
    if (transfer.done) return;
    this.totals.transactions++;
    if (transfer.endpoint !== undefined) {
      this.begin_in(transfer.endpoint, (answer) => this.interrupt_answered(transfer, answer));
    } else if (this.queue.now - transfer.started > CONTROL_TIMEOUT) {
      this.finish_control(transfer, new UsbError("TIMEOUT", transfer.what));
    } else if (transfer.stage === "setup") {
      this.begin_setup(transfer);
    } else if (transfer.to_host === (transfer.stage === "data") || transfer.length === 0) {
      this.begin_in(0, (answer) => this.control_in_answered(transfer, answer));
    } else {
      this.begin_out(transfer);
    }
  }

  begin_setup(transfer) {
    this.occupy(TOKEN_BITS + GAP_BITS + data_bits(8) + TURN_BITS + HANDSHAKE_BITS + GAP_BITS, () => {
      const answer = this.port()?.setup(this.address, 0, transfer.setup);
      if (answer !== "ack") return this.no_answer(transfer);
      transfer.retries = 0;
      transfer.toggle = 1;
      transfer.sent = 0;
      transfer.stage = transfer.length > 0 ? "data" : "status";
      return undefined;
    });
  }

  /** OUT data of a control write, or the empty status packet of a control read. */
  begin_out(transfer) {
    const status = transfer.stage === "status";
    const data = status ? new Uint8Array(0) : transfer.out.slice(transfer.sent, transfer.sent + this.max_packet_0);
    const corrupt = !status && this.faults.corrupt_toggle > 0;
    const pid = status ? 1 : transfer.toggle ^ (corrupt ? 1 : 0);
    this.occupy(TOKEN_BITS + GAP_BITS + data_bits(data.length) + TURN_BITS + HANDSHAKE_BITS + GAP_BITS, () => {
      const answer = this.port()?.out(this.address, 0, pid, data);
      if (answer === "nak") return this.nak();
      if (answer === "stall") return this.finish_control(transfer, new UsbError("STALL", transfer.what));
      if (answer !== "ack") return this.no_answer(transfer);
      if (corrupt) this.faults.corrupt_toggle--;
      transfer.retries = 0;
      if (status) return this.finish_control(transfer);
      transfer.toggle ^= 1;
      transfer.sent += data.length;
      if (transfer.sent >= transfer.length) transfer.stage = "status";
      return undefined;
    });
  }

  /** Asks an endpoint for data; the device answers when it has the token, and learns of the ACK at the end. */
  begin_in(endpoint, take) {
    this.occupy(TOKEN_BITS, () => {
      const answer = this.port()?.in(this.address, endpoint);
      if (answer === undefined || typeof answer === "string") {
        this.occupy(TURN_BITS + HANDSHAKE_BITS + GAP_BITS, () => take(answer));
      } else {
        const bits = TURN_BITS + data_bits(answer.data.length) + TURN_BITS + HANDSHAKE_BITS + GAP_BITS;
        this.occupy(bits, () => this.acknowledge(endpoint, answer, take));
      }
    });
  }

  acknowledge(endpoint, answer, take) {
    const port = this.port();
    if (this.faults.lose_data > 0) {
      this.faults.lose_data--;
      port?.in_lost();
      return take(undefined);
    }
    if (this.faults.lose_ack > 0) {
      this.faults.lose_ack--;
      port?.in_lost(); // the packet has arrived here, but the device does not know
    } else {
      port?.in_acked(endpoint);
    }
    return take(answer);
  }

  nak() {
    this.totals.naks++;
  }

  no_answer(transfer) {
    this.totals.no_answers++;
    transfer.retries++;
    if (transfer.retries < RETRIES) return;
    const error = new UsbError("NO_ANSWER", transfer.what);
    if (transfer.setup) this.finish_control(transfer, error);
    else this.finish_interrupt(transfer, error);
  }

  interrupt_answered(transfer, answer) {
    if (transfer.done) return;
    if (answer === "nak") return this.nak();
    if (answer === "stall") return this.finish_interrupt(transfer, new UsbError("STALL", transfer.what));
    if (answer === undefined) return this.no_answer(transfer);
    const expected = this.toggles.get(transfer.endpoint) ?? 0;
    transfer.retries = 0;
    if (answer.pid !== expected) {
      this.totals.toggle_errors++; // a packet that was here before: acknowledged, not used
      return undefined;
    }
    this.toggles.set(transfer.endpoint, expected ^ 1);
    return this.finish_interrupt(transfer, undefined, answer.data);
  }

  control_in_answered(transfer, answer) {
    if (transfer.done) return undefined;
    if (answer === "nak") return this.nak();
    if (answer === "stall") return this.finish_control(transfer, new UsbError("STALL", transfer.what));
    if (answer === undefined) return this.no_answer(transfer);
    transfer.retries = 0;
    if (answer.pid !== transfer.toggle && transfer.stage === "data") {
      this.totals.toggle_errors++;
      return undefined;
    }
    if (transfer.stage === "status") {
      if (answer.pid !== 1) this.totals.toggle_errors++;
      return this.finish_control(transfer);
    }
    transfer.toggle ^= 1;
    transfer.received.push(...answer.data);
    const short = answer.data.length < this.max_packet_0;
    if (short || transfer.received.length >= transfer.length) transfer.stage = "status";
    return undefined;
  }

  finish_control(transfer, error) {
    this.controls = this.controls.filter((other) => other !== transfer);
    this.totals.controls++;
    if (!error) this.follow_toggles(transfer.setup);
    transfer.end(error, error ? undefined : Uint8Array.from(transfer.received).slice(0, transfer.length));
  }

  /** SET_CONFIGURATION, SET_INTERFACE and CLEAR_FEATURE (halt) begin endpoints anew with DATA0. */
  follow_toggles(setup) {
    const request = (setup[0] << 8) | setup[1];
    if (request === 0x0009 || request === 0x010b) this.toggles.clear();
    if (request === 0x0201 && setup[2] === 0) this.toggles.delete(setup[4] & 15);
  }

  finish_interrupt(transfer, error, data) {
    this.interrupts = this.interrupts.filter((other) => other !== transfer);
    transfer.end(error, data);
  }

  /** Simulated time in nanoseconds. */
  get time_ns() {
    return this.queue.now * CYCLE_NS;
  }
}
