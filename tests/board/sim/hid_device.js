// SPDX-License-Identifier: MIT
// A HID device as a host's driver sees it: enumeration in Linux' order, reports polled into a queue, feature reports.
import { CYCLE_NS } from "./event_queue.js";

const GET_DESCRIPTOR = 6, SET_ADDRESS = 5, SET_CONFIGURATION = 9;
const DEVICE = 1, CONFIGURATION = 2, STRING = 3, HID = 0x21, REPORT = 0x22;
const GET_REPORT = 1, SET_REPORT = 9, SET_IDLE = 10;
const FEATURE = 3;
const LANGUAGE = 0x0409;

export function setup_packet(type, request, value, index, length) {
  return Uint8Array.of(type, request, value & 255, value >>> 8, index & 255, index >>> 8, length & 255, length >>> 8);
}

export function get_descriptor(type, index, language, length) {
  return setup_packet(0x80, GET_DESCRIPTOR, (type << 8) | index, language, length);
}

/** Runs generators that yield what they wait for: { setup, data }, { reset_ms } or { wait_ms }. */
export function run_script(host, script, on_error) {
  const advance = (act) => {
    let step;
    try {
      step = act();
    } catch (error) {
      on_error(error);
      return;
    }
    if (step.done) return;
    const wanted = step.value;
    if (wanted.setup) {
      host.control(wanted.setup, wanted.data, (transfer) =>
        advance(() => (transfer.error ? script.throw(transfer.error) : script.next(transfer.data))));
    } else if (wanted.reset_ms !== undefined) {
      host.reset_bus(wanted.reset_ms, () => advance(() => script.next()));
    } else {
      host.later(wanted.wait_ms * 125000, () => advance(() => script.next()));
    }
  };
  advance(() => script.next());
}

export class HidDevice {
  constructor(host) {
    this.host = host;
    this.ready = false;
    this.error = undefined;
    this.reports = []; // { cycle, time_ns, data }
    this.strings = {};
    this.interface_number = 0;
    this.in_endpoint = undefined;
  }

  /** From a pull-up that was just seen to polled reports. `times`: shorter waits than a real host's. */
  *enumerate(times) {
    const { host } = this;
    yield { wait_ms: times.settle_ms };
    yield { reset_ms: times.reset_ms };
    yield { wait_ms: times.recovery_ms };
    const first = yield { setup: get_descriptor(DEVICE, 0, 0, 64) };
    host.max_packet_0 = first[7];
    yield { reset_ms: times.reset_ms };
    yield { wait_ms: times.recovery_ms };
    yield { setup: setup_packet(0, SET_ADDRESS, times.address, 0, 0) };
    host.address = times.address;
    yield { wait_ms: 2 };
    this.device_descriptor = yield { setup: get_descriptor(DEVICE, 0, 0, 18) };
    const head = yield { setup: get_descriptor(CONFIGURATION, 0, 0, 9) };
    this.configuration = yield { setup: get_descriptor(CONFIGURATION, 0, 0, head[2] | (head[3] << 8)) };
    for (const [name, at] of [["manufacturer", 14], ["product", 15], ["serial", 16]]) {
      const index = this.device_descriptor[at];
      if (index === 0) continue;
      const bytes = yield { setup: get_descriptor(STRING, index, LANGUAGE, 255) };
      this.strings[name] = Buffer.from(bytes.slice(2)).toString("utf16le");
    }
    yield { setup: setup_packet(0, SET_CONFIGURATION, this.configuration[5], 0, 0) };
    const report_bytes = this.read_configuration();
    if (report_bytes !== undefined) {
      try {
        yield { setup: setup_packet(0x21, SET_IDLE, 0, this.interface_number, 0) };
      } catch (error) {
        if (error.code !== "STALL") throw error; // a device need not have it
      }
      const get_report = setup_packet(0x81, GET_DESCRIPTOR, REPORT << 8, this.interface_number, report_bytes);
      this.report_descriptor = yield { setup: get_report };
    }
    this.ready = true;
    if (this.in_endpoint) this.poll();
  }

  /** Finds the HID interface, its endpoint and the length of its report descriptor. */
  read_configuration() {
    const bytes = this.configuration;
    let report_bytes;
    for (let at = 0; at + 1 < bytes.length && bytes[at] > 0; at += bytes[at]) {
      if (bytes[at + 1] === 4 && bytes[at + 5] === 3) this.interface_number = bytes[at + 2];
      if (bytes[at + 1] === HID) report_bytes = bytes[at + 7] | (bytes[at + 8] << 8);
      if (bytes[at + 1] === 5 && bytes[at + 2] & 0x80) {
        this.in_endpoint = { number: bytes[at + 2] & 15, interval_ms: bytes[at + 6] };
      }
    }
    return report_bytes;
  }

  poll() {
    const { number, interval_ms } = this.in_endpoint;
    this.host.interrupt_in(number, interval_ms, (transfer) => {
      if (transfer.error) return;
      const cycle = this.host.queue.now;
      this.reports.push({ cycle, time_ns: cycle * CYCLE_NS, data: transfer.data });
      this.poll();
    });
  }

  /** Starts a GET_REPORT of a feature; the transfer's data begin with the report's number. */
  start_get_feature(id, length, on_done) {
    const setup = setup_packet(0xa1, GET_REPORT, (FEATURE << 8) | id, this.interface_number, length);
    return this.host.control(setup, undefined, on_done);
  }

  /** bytes[0] is the report's number. */
  start_set_feature(bytes, on_done) {
    const data = Uint8Array.from(bytes);
    const setup = setup_packet(0x21, SET_REPORT, (FEATURE << 8) | data[0], this.interface_number, data.length);
    return this.host.control(setup, data, on_done);
  }
}
