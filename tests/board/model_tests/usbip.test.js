// SPDX-License-Identifier: MIT
// The USB/IP server, in real time: a blank board is flashed through PICOBOOT and comes back as its firmware's device.
// GLINT_FIRMWARE names the firmware (UF2 or raw); without it, what needs one is skipped.
import assert from "node:assert/strict";
import { after, test } from "node:test";
import { flash_image } from "../sim/board.js";
import { setup_packet } from "../sim/hid_device.js";
import { make_boards, UsbipServer } from "../usbip_server.js";
import { Control, UsbipClient } from "./usbip_client.js";

const firmware = process.env.GLINT_FIRMWARE;
const servers = [];
after(() => servers.forEach((server) => server.close()));

async function serve(count, image) {
  const server = new UsbipServer(make_boards(count, image));
  servers.push(server);
  return { server, ...(await server.listen()) };
}

let token = 0;
function command(number, length, ...words) {
  const bytes = Buffer.alloc(32);
  bytes.writeUInt32LE(0x431fd10b, 0);
  bytes.writeUInt32LE(++token, 4);
  bytes[8] = number;
  bytes.writeUInt32LE(length, 12);
  bytes[9] = number === 1 ? 1 : 4 * words.length;
  words.forEach((word, index) => bytes.writeUInt32LE(word, 16 + 4 * index));
  return bytes;
}

/** One PICOBOOT command; the error that the ROM reports, 0 for none, and what was read. */
async function picoboot(client, number, words = [], data) {
  const reads = (number & 0x80) !== 0;
  const moved = reads ? words[1] : data?.length ?? 0;
  const sent = await client.out(3, command(number, moved, ...words));
  let result = sent.status === 0 ? undefined : sent;
  let read;
  if (result === undefined && reads) {
    read = (await client.in(4, moved)).data;
    result = await client.out(3, []);
  } else if (result === undefined) {
    if (data) await client.out(3, data);
    result = await client.in(4, 0);
  }
  if (result.status === 0) return { code: 0, read };
  assert.equal(result.status, -32);
  const { data: status } = await client.control(setup_packet(0xc1, 0x42, 0, 1, 16));
  assert.equal(status.readUInt32LE(0), token);
  await client.control(setup_packet(0x41, 0x41, 0, 1, 0));
  return { code: status.readUInt32LE(4), read };
}

test("a blank board shows the ROM: descriptors, errors of each kind, erase, write, read", async () => {
  const { server, port, control_port } = await serve(1);
  const client = await UsbipClient.connect(port);
  assert.deepEqual(await client.import("1-1"), { busid: "1-1", speed: 2, vendor: 0x2e8a, product: 3 });
  const product = await client.control(setup_packet(0x80, 6, 0x0302, 0x409, 255));
  assert.equal(product.data.subarray(2).toString("utf16le"), "RP2 Boot");
  assert.equal((await client.control(setup_packet(0xc0, 0x77, 0, 0, 4))).status, -32);
  assert.equal((await client.control(setup_packet(0xc1, 0x42, 0, 0, 16))).status, -32, "interface 0 is the mass storage");
  assert.equal((await picoboot(client, 1, [1])).code, 0);
  assert.equal((await picoboot(client, 0x0e)).code, 1, "unknown");
  assert.equal((await picoboot(client, 3, [0x10000000])).code, 2, "length of the arguments");
  assert.equal((await picoboot(client, 3, [0x10000100, 4096])).code, 5, "alignment");
  assert.equal((await picoboot(client, 3, [0x10200000, 4096])).code, 4, "behind the flash");
  assert.equal((await picoboot(client, 5, [0x10000080, 256], Buffer.alloc(256))).code, 5);
  const page = Buffer.from(Array.from({ length: 512 }, (_, index) => index & 255));
  assert.equal((await picoboot(client, 3, [0x10001000, 4096])).code, 0);
  assert.equal((await picoboot(client, 5, [0x10001000, 512], page)).code, 0);
  assert.equal((await picoboot(client, 5, [0x10001000, 256], Buffer.alloc(256, 0xf0))).code, 0, "without erasing: AND");
  const { read } = await picoboot(client, 0x84, [0x10001000, 768]);
  const expected = (index) => (index < 256 ? index & 0xf0 : index < 512 ? index & 255 : 255);
  assert.deepEqual([...read], Array.from({ length: 768 }, (_, index) => expected(index)));
  const control = await Control.connect(control_port);
  assert.equal((await control.ask("status")).state, "bootsel");
  await assert.rejects(control.ask("9 status"), /there is no board 9/);
  await control.ask("unplug");
  await client.closed;
  control.close();
  server.close();
});

test("two boards at once; an unknown bus id is refused", async () => {
  const { server, port } = await serve(2);
  const [first, second, third] = await Promise.all([1, 2, 3].map(() => UsbipClient.connect(port)));
  assert.equal((await first.import("1-1")).product, 3);
  assert.equal((await second.import("1-2")).product, 3);
  await assert.rejects(third.import("1-3"), /refused/);
  const { reply, seqnum } = first.start_in(4, 64);
  assert.equal((await first.unlink(seqnum)).status, -104);
  void reply;
  first.close();
  second.close();
  server.close();
});

test("flashed over PICOBOOT, rebooted, imported again: HID, reports, a refusal, the watchdog",
  { skip: firmware ? false : "GLINT_FIRMWARE names no firmware" },
  async () => {
    const { server, port, control_port } = await serve(1);
    const control = await Control.connect(control_port);
    const rom = await UsbipClient.connect(port);
    await rom.import("1-1");
    const image = flash_image(firmware);
    const padded = Buffer.concat([image, Buffer.alloc(-image.length & 255, 0xff)]);
    assert.equal((await picoboot(rom, 3, [0x10000000, (padded.length + 4095) & ~4095])).code, 0);
    assert.equal((await picoboot(rom, 5, [0x10000000, padded.length], padded)).code, 0);
    assert.deepEqual((await picoboot(rom, 0x84, [0x10000000, padded.length])).read, padded);
    assert.equal((await picoboot(rom, 2, [0, 0, 50])).code, 0);
    await rom.closed;
    const client = await UsbipClient.connect(port);
    const { vendor } = await client.import("1-1");
    assert.equal(vendor, 0x1209);
    assert.equal((await client.control(setup_packet(0, 9, 1, 0, 0))).status, 0);
    const info = await client.control(setup_packet(0xa1, 1, 0x315, 0, 64));
    assert.equal(info.data[0], 0x15);
    assert.equal((await client.control(setup_packet(0x21, 9, 0x3ee, 0, 2), [0xee, 1])).status, -32);
    const { reply } = client.start_in(1, 64, 1);
    const booted = await reply;
    assert.deepEqual([booted.status, booted.data[0]], [0, 1], "the first input report");
    await control.ask("watch 2");
    assert.deepEqual((await control.ask("edges 2")).map(([, level]) => level), [0]);
    await control.ask("stop-processor");
    await client.closed;
    const again = await UsbipClient.connect(port);
    await again.import("1-1");
    const status = await control.ask("status");
    assert.deepEqual(status.resets.map(({ cause }) => cause), ["power", "reboot", "watchdog"]);
    assert.deepEqual(status.complaints, []);
    again.close();
    control.close();
    server.close();
  });
