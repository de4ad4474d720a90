// SPDX-License-Identifier: MIT
// The USB device controller and the host, token by token: what firmware writes into registers and DPRAM, and what then
// crosses the bus.
import assert from "node:assert/strict";
import { test } from "node:test";
import { setup_packet } from "../sim/hid_device.js";
import { UsbHost } from "../sim/usb_host.js";
import { Bench } from "./bench.js";

const USB = 0x50110000, MEMORY = 0x50100000;
const SIE_STATUS = USB + 0x50, BUFF_STATUS = USB + 0x58, SHOULD_HANDLE = USB + 0x5c, STALL_ARM = USB + 0x68;
const FULL = 0x8000, LAST = 0x4000, DATA1 = 0x2000, STALL = 0x800, AVAILABLE = 0x400;
const IN0 = MEMORY + 0x80, OUT0 = MEMORY + 0x84, IN1 = MEMORY + 0x88, OUT1 = MEMORY + 0x8c;

/** A device without firmware, pulled up, at the end of a host's cable; frames run. */
class Wire extends Bench {
  constructor() {
    super();
    this.write(0x4002c008, 100); // PLL_USB: 48 MHz
    this.write(0x4002c004, 0);
    this.write(0x4002c00c, (5 << 16) | (5 << 12));
    this.write(0x40008054, 0x800);
    this.host = new UsbHost(this.chip.queue, () => this.chip.usb);
    this.chip.usb.on_attach_change = () => this.host.pull_up_changed();
    this.write(USB + 0x74, 9);
    this.write(USB + 0x78, 0xc);
    this.write(USB + 0x40, 1);
    this.write(USB + 0x4c, (1 << 29) | (1 << 16)); // EP0_INT_1BUF, PULLUP_EN
    this.host.run_frames();
    this.chip.on_exception = null;
  }

  /** Gives a buffer to the controller, AVAILABLE after the rest. */
  arm(control, bits, data = []) {
    const address = control < IN1 ? 0x100 : this.chip.usb.memory[(control - MEMORY - 0x80) / 4] & 0xffc0;
    data.forEach((byte, index) => this.chip.core.writeUint8(MEMORY + address + index, byte));
    this.write(control, bits | data.length);
    this.run(12);
    this.write(control, bits | data.length | AVAILABLE);
  }

  /** Does `act` whenever the condition is seen, looking every microsecond, until the transfer has ended. */
  until_done(transfer, reactions = []) {
    for (let microsecond = 0; microsecond < 20_000 && !transfer.done; microsecond++) {
      for (const [condition, act] of reactions) if (condition()) act();
      this.run(125);
    }
    assert.ok(transfer.done, "the transfer ends");
    return transfer;
  }

  status(bit) {
    return (this.read(SIE_STATUS) >>> bit) & 1;
  }
}

test("a control read: SETUP lands at 0 and interrupts, IN is NAKed until there is data; then an empty OUT", () => {
  const wire = new Wire();
  wire.write(USB + 0x90, 1 << 16); // INTE.SETUP_REQ
  const transfer = wire.host.control(setup_packet(0x80, 6, 0x100, 0, 4));
  wire.run(125 * 20);
  assert.equal(wire.read(MEMORY), 0x01000680);
  assert.equal(wire.chip.core.lines & (1 << 5), 1 << 5);
  wire.write(USB + 0x3000 + 0x50, 1 << 17); // SETUP_REC, CLEAR alias
  assert.equal(wire.chip.core.lines & (1 << 5), 0);
  wire.run(125 * 100);
  const naks = wire.host.totals.naks;
  assert.ok(naks > 15 && naks < 22, `${naks} NAKs in 100 us, at 5.2 us each`);
  wire.arm(IN0, FULL | LAST | DATA1, [1, 2, 3, 4]);
  wire.arm(OUT0, DATA1 | 0);
  wire.until_done(transfer);
  assert.deepEqual([...transfer.data], [1, 2, 3, 4]);
  assert.equal(wire.read(BUFF_STATUS), 3);
  assert.equal(wire.read(IN0) & (FULL | AVAILABLE), 0);
  assert.equal(wire.read(OUT0) & (FULL | AVAILABLE), FULL);
  assert.equal(wire.status(18), 1, "TRANS_COMPLETE by LAST");
  wire.write(BUFF_STATUS, 1);
  assert.equal(wire.read(BUFF_STATUS), 2);
  assert.equal(wire.host.totals.toggle_errors, 0);
  assert.deepEqual([...wire.chip.complaints], []);
});

test("a transfer takes the bus' time: 8 bytes of SETUP, 64 of data and the status in 73.1 us", () => {
  const wire = new Wire();
  wire.arm(IN0, FULL | DATA1, new Array(64).fill(0x5a));
  wire.arm(OUT0, DATA1);
  wire.run(125_000 - (wire.cycle % 125_000) + 2000);
  const begin = wire.cycle;
  const transfer = wire.host.control(setup_packet(0x80, 6, 0x100, 0, 64));
  while (!transfer.done) wire.run(5);
  const took_us = (wire.cycle - begin) / 125;
  assert.ok(Math.abs(took_us - 877 / 12) < 0.2, `${took_us}`); // 163, 615 and 99 bits
});

test("a refused request: STALL on endpoint 0 only when armed, and the next SETUP disarms it", () => {
  const wire = new Wire();
  wire.write(IN0, STALL);
  const first = wire.host.control(setup_packet(0xc0, 1, 0, 0, 4));
  wire.run(125 * 60);
  assert.equal(first.done, false, "not armed: NAK");
  wire.write(STALL_ARM, 3);
  wire.until_done(first);
  assert.equal(first.error.code, "STALL");
  const second = wire.host.control(setup_packet(0xc0, 1, 0, 0, 4));
  wire.run(125 * 60);
  assert.equal(wire.read(STALL_ARM), 0);
  assert.equal(second.done, false);
});

test("a control write: data in OUT buffers of DATA1, DATA0; a wrong toggle is acknowledged and not used", () => {
  const wire = new Wire();
  wire.arm(OUT0, DATA1 | 64);
  const data = Uint8Array.from({ length: 70 }, (_, index) => index);
  const transfer = wire.host.control(setup_packet(0x21, 9, 0x310, 0, 70), data);
  wire.run(125 * 120);
  assert.equal(wire.read(OUT0) & 0x3ff, 64);
  assert.equal(wire.chip.usb.bytes[0x100 + 63], 63);
  wire.host.faults.corrupt_toggle = 1;
  wire.run(125 * 30);
  wire.arm(OUT0, 64);
  wire.run(125 * 60);
  assert.equal(wire.status(31), 1, "DATA_SEQ_ERROR");
  assert.equal(wire.read(OUT0) & FULL, 0);
  assert.equal(transfer.done, false);
});

test("EP1 IN: polled once an interval, toggles; a lost ACK brings the packet again, once for the application", () => {
  const wire = new Wire();
  wire.write(MEMORY + 0x08, 0xa0000000 | (3 << 26) | 0x180); // ENABLE, INTERRUPT_PER_BUFF, interrupt
  const got = [];
  const poll = () => wire.host.interrupt_in(1, 2, (transfer) => {
    got.push(transfer.data?.[0] ?? transfer.error.code);
    if (!transfer.error) poll();
  });
  poll();
  wire.run(1_250_000);
  assert.equal(wire.host.totals.naks, 5, "every second frame");
  let pid = 0;
  const send = (value) => {
    wire.arm(IN1, FULL | (pid ? DATA1 : 0), [value]);
    pid ^= 1;
    wire.run(250_000);
  };
  send(10);
  send(11);
  assert.deepEqual(got, [10, 11]);
  assert.equal(wire.read(BUFF_STATUS), 4);
  wire.write(BUFF_STATUS, 4);
  wire.host.faults.lose_ack = 1;
  send(12);
  assert.deepEqual(got, [10, 11, 12]);
  assert.equal(wire.read(IN1) & AVAILABLE, AVAILABLE, "the device still has it");
  assert.equal(wire.status(27), 1, "RX_TIMEOUT");
  wire.run(250_000);
  assert.deepEqual(got, [10, 11, 12]);
  assert.equal(wire.host.totals.toggle_errors, 1);
  assert.equal(wire.read(BUFF_STATUS), 4);
  send(13);
  assert.deepEqual(got, [10, 11, 12, 13]);
  pid ^= 1; // firmware that forgets to toggle
  send(14);
  assert.deepEqual(got, [10, 11, 12, 13]);
  wire.write(IN1, STALL);
  wire.run(250_000);
  assert.deepEqual(got.slice(4), ["STALL"]);
});

test("double buffers: both can be full, are sent in turn, and each is reported", () => {
  const wire = new Wire();
  wire.write(MEMORY + 0x08, 0xe0000000 | (3 << 26) | 0x180);
  const got = [];
  const poll = () => wire.host.interrupt_in(1, 1, (transfer) => {
    got.push(transfer.data[0]);
    poll();
  });
  poll();
  wire.chip.core.writeUint8(MEMORY + 0x180, 1);
  wire.chip.core.writeUint8(MEMORY + 0x1c0, 2);
  const both = (FULL | 1) | ((FULL | DATA1 | 1) << 16);
  wire.write(IN1, both | 0x1000);
  wire.run(12);
  wire.write(IN1, both | AVAILABLE | (AVAILABLE << 16));
  wire.run(125_000 * 3);
  assert.deepEqual(got, [1, 2]);
  assert.deepEqual([wire.read(BUFF_STATUS), wire.read(SHOULD_HANDLE)], [4, 0]);
  wire.write(BUFF_STATUS, 4);
  assert.deepEqual([wire.read(BUFF_STATUS), wire.read(SHOULD_HANDLE)], [4, 4], "set again for the second");
  wire.write(BUFF_STATUS, 4);
  assert.deepEqual([wire.read(BUFF_STATUS), wire.read(SHOULD_HANDLE)], [0, 0]);
});

test("SOF each millisecond; bus reset; suspend and resume; the pull-up is attachment", () => {
  const wire = new Wire();
  wire.write(USB + 0x90, 1 << 17);
  let frames = 0;
  for (let millisecond = 0; millisecond < 10; millisecond++) {
    wire.run(125_000);
    if (wire.chip.core.lines & (1 << 5)) frames++;
    wire.read(USB + 0x48);
    assert.equal(wire.chip.core.lines & (1 << 5), 0);
  }
  assert.equal(frames, 10);
  const pending = wire.host.control(setup_packet(0x80, 6, 0x100, 0, 4));
  let done = false;
  wire.host.reset_bus(10, () => { done = true; });
  assert.equal(pending.error.code, "RESET");
  assert.equal(wire.status(19), 1);
  const frame = wire.read(USB + 0x48);
  wire.run(125_000 * 9);
  assert.equal(wire.read(USB + 0x48), frame, "no frames in reset");
  wire.run(125_000 * 2);
  assert.ok(done);
  wire.host.suspend();
  wire.run(125_000 * 2);
  assert.equal(wire.status(4), 0);
  wire.run(125_000 * 2);
  assert.equal(wire.status(4), 1);
  assert.equal(wire.read(USB + 0x8c) & (1 << 14), 1 << 14);
  wire.host.resume();
  assert.deepEqual([wire.status(4), wire.status(11)], [0, 1]);
  let detached = 0;
  wire.host.on_detach = () => { detached++; };
  wire.write(USB + 0x3000 + 0x4c, 1 << 16);
  assert.equal(detached, 1);
  assert.equal(wire.host.control(setup_packet(0x80, 6, 0x100, 0, 4)).error.code, "DETACHED");
});

test("OUT to an endpoint: NAK while full, overflow unanswered, silence at another address", () => {
  const wire = new Wire();
  const { usb } = wire.chip;
  wire.write(MEMORY + 0x0c, 0xa0000000 | (2 << 26) | 0x180);
  assert.equal(usb.out(0, 1, 0, [1]), "nak");
  wire.arm(OUT1, 64);
  assert.equal(usb.out(0, 1, 0, [7, 8, 9]), "ack");
  assert.equal(wire.read(BUFF_STATUS), 8);
  assert.equal(wire.read(OUT1) & 0x3ff, 3);
  assert.equal(usb.out(0, 1, 1, [1]), "nak");
  wire.arm(OUT1, DATA1 | 2);
  assert.equal(usb.out(0, 1, 1, [1, 2, 3]), undefined);
  assert.equal(wire.status(26), 1);
  assert.equal(usb.out(9, 1, 1, [1]), undefined);
  assert.equal(usb.in(0, 3), undefined, "not enabled");
});

test("AVAILABLE in one write with the rest is a complaint", () => {
  const wire = new Wire();
  wire.write(IN0, FULL | DATA1 | AVAILABLE | 4);
  assert.match([...wire.chip.complaints.keys()].join(), /AVAILABLE/);
});
