// SPDX-License-Identifier: MIT
// USB/IP as it goes over the wire (Documentation/usb/usbip_protocol.rst of Linux): big-endian words.

const VERSION = 0x0111;
const REQUEST_LIST = 0x8005, REPLY_LIST = 0x0005, REQUEST_IMPORT = 0x8003, REPLY_IMPORT = 0x0003;
const SUBMIT = 1, UNLINK = 2, SUBMIT_REPLY = 3, UNLINK_REPLY = 4;
const HEADER = 48, BUSID = 32;
const FULL_SPEED = 2;

/** Takes bytes as they come and gives whole messages. */
export class Reader {
  constructor() {
    this.bytes = Buffer.alloc(0);
    this.imported = false; // before: requests of the exporter's protocol; after: transfers
  }

  push(chunk) {
    this.bytes = Buffer.concat([this.bytes, chunk]);
  }

  take(count) {
    const taken = this.bytes.subarray(0, count);
    this.bytes = this.bytes.subarray(count);
    return taken;
  }

  /** { kind: "list" | "import" | "submit" | "unlink" | "unknown", ... } or undefined while it is not all there. */
  next() {
    return this.imported ? this.next_transfer() : this.next_request();
  }

  next_request() {
    if (this.bytes.length < 8) return undefined;
    const code = this.bytes.readUInt16BE(2);
    if (code === REQUEST_LIST) {
      this.take(8);
      return { kind: "list" };
    }
    if (code !== REQUEST_IMPORT) return { kind: "unknown", code };
    if (this.bytes.length < 8 + BUSID) return undefined;
    const text = this.take(8 + BUSID).subarray(8).toString("latin1");
    return { kind: "import", busid: text.slice(0, text.indexOf("\0")) };
  }

  next_transfer() {
    const { bytes } = this;
    if (bytes.length < HEADER) return undefined;
    const command = bytes.readUInt32BE(0);
    const seqnum = bytes.readUInt32BE(4);
    if (command === UNLINK) {
      const unlinked = this.take(HEADER).readUInt32BE(20);
      return { kind: "unlink", seqnum, unlinked };
    }
    if (command !== SUBMIT) return { kind: "unknown", code: command };
    const to_host = bytes.readUInt32BE(12) !== 0;
    const length = bytes.readInt32BE(24);
    const whole = HEADER + (to_host ? 0 : length);
    if (bytes.length < whole) return undefined;
    const message = Buffer.from(this.take(whole));
    return { kind: "submit", seqnum, to_host, length,
      endpoint: message.readUInt32BE(16), interval: message.readInt32BE(36),
      setup: Uint8Array.from(message.subarray(40, 48)), data: Uint8Array.from(message.subarray(HEADER)) };
  }
}

/** The 312 bytes that describe a device: { busid, number, device_descriptor, configuration }. */
function device_record({ busid, number, device_descriptor, configuration }) {
  const record = Buffer.alloc(312);
  record.write(`/sys/devices/simulated/usb1/${busid}`, 0, "latin1");
  record.write(busid, 256, "latin1");
  record.writeUInt32BE(1, 288);
  record.writeUInt32BE(number, 292);
  record.writeUInt32BE(FULL_SPEED, 296);
  record.writeUInt16BE(device_descriptor[8] | (device_descriptor[9] << 8), 300);
  record.writeUInt16BE(device_descriptor[10] | (device_descriptor[11] << 8), 302);
  record.writeUInt16BE(device_descriptor[12] | (device_descriptor[13] << 8), 304);
  record.set([device_descriptor[4], device_descriptor[5], device_descriptor[6], 0, device_descriptor[17],
    configuration[4]], 306);
  return record;
}

function reply_header(code, status) {
  const header = Buffer.alloc(8);
  header.writeUInt16BE(VERSION, 0);
  header.writeUInt16BE(code, 2);
  header.writeUInt32BE(status, 4);
  return header;
}

export function list_reply(devices) {
  const count = Buffer.alloc(4);
  count.writeUInt32BE(devices.length);
  const records = devices.map((device) => {
    const interfaces = [];
    const { configuration } = device;
    for (let at = 0; at < configuration.length && configuration[at] > 0; at += configuration[at]) {
      if (configuration[at + 1] === 4) interfaces.push(...configuration.slice(at + 5, at + 8), 0);
    }
    return Buffer.concat([device_record(device), Buffer.from(interfaces)]);
  });
  return Buffer.concat([reply_header(REPLY_LIST, 0), count, ...records]);
}

/** Without a device: refused. */
export function import_reply(device) {
  if (device === undefined) return reply_header(REPLY_IMPORT, 1);
  return Buffer.concat([reply_header(REPLY_IMPORT, 0), device_record(device)]);
}

/** status: 0 or a negative errno. */
export function submit_reply(request, status, data) {
  const carried = request.to_host && status === 0 ? Buffer.from(data ?? []) : Buffer.alloc(0);
  const reply = Buffer.alloc(HEADER);
  reply.writeUInt32BE(SUBMIT_REPLY, 0);
  reply.writeUInt32BE(request.seqnum, 4);
  reply.writeInt32BE(status, 20);
  reply.writeUInt32BE(status !== 0 ? 0 : request.to_host ? carried.length : request.data.length, 24);
  return Buffer.concat([reply, carried]);
}

export function unlink_reply(request, status) {
  const reply = Buffer.alloc(HEADER);
  reply.writeUInt32BE(UNLINK_REPLY, 0);
  reply.writeUInt32BE(request.seqnum, 4);
  reply.writeInt32BE(status, 20);
  return reply;
}
