// SPDX-License-Identifier: MIT
// The other end of USB/IP, as the kernel's would be, for tests: import, transfers, unlink.
import { connect } from "node:net";
import { once } from "node:events";

export class UsbipClient {
  static async connect(port) {
    const client = new UsbipClient();
    client.socket = connect(port, "127.0.0.1");
    client.bytes = Buffer.alloc(0);
    client.wanted = [];
    client.seqnum = 0;
    client.replies = new Map();
    client.closed = once(client.socket, "close");
    client.socket.on("error", () => {});
    client.socket.on("data", (chunk) => {
      client.bytes = Buffer.concat([client.bytes, chunk]);
      client.serve();
    });
    await once(client.socket, "connect");
    client.socket.setNoDelay(true);
    return client;
  }

  serve() {
    while (this.wanted.length > 0 && this.bytes.length >= this.wanted[0].count) {
      const { count, resolve } = this.wanted.shift();
      const taken = this.bytes.subarray(0, count);
      this.bytes = this.bytes.subarray(count);
      resolve(taken);
    }
    if (this.imported) this.serve_replies();
  }

  take(count) {
    return new Promise((resolve) => {
      this.wanted.push({ count, resolve });
      this.serve();
    });
  }

  /** Resolves to { vendor, product } once the server has a device. */
  async import(busid) {
    const request = Buffer.alloc(40);
    request.writeUInt16BE(0x0111, 0);
    request.writeUInt16BE(0x8003, 2);
    request.write(busid, 8);
    this.socket.write(request);
    const header = await this.take(8);
    if (header.readUInt32BE(4) !== 0) throw new Error(`import of ${busid} is refused`);
    const record = await this.take(312);
    this.imported = true;
    return { busid: record.toString("latin1", 256, 256 + busid.length), speed: record.readUInt32BE(296),
      vendor: record.readUInt16BE(300), product: record.readUInt16BE(302) };
  }

  serve_replies() {
    while (this.bytes.length >= 48) {
      const unlinked = this.bytes.readUInt32BE(0) === 4;
      const status = this.bytes.readInt32BE(20);
      const waiting = this.replies.get(this.bytes.readUInt32BE(4));
      const carried = !unlinked && waiting.to_host ? this.bytes.readUInt32BE(24) : 0;
      if (this.bytes.length < 48 + carried) return;
      const data = Buffer.from(this.bytes.subarray(48, 48 + carried));
      this.bytes = this.bytes.subarray(48 + carried);
      waiting.resolve({ status, data });
    }
  }

  send(command, fields, to_host, data = Buffer.alloc(0)) {
    const seqnum = ++this.seqnum;
    const header = Buffer.alloc(48);
    header.writeUInt32BE(command, 0);
    header.writeUInt32BE(seqnum, 4);
    for (const [at, value] of fields) header.writeUInt32BE(value, at);
    this.socket.write(Buffer.concat([header, data]));
    return { seqnum, reply: new Promise((resolve) => this.replies.set(seqnum, { resolve, to_host })) };
  }

  /** A transfer; its reply resolves to { status, data }. */
  start_in(endpoint, length, interval = 0) {
    return this.send(1, [[12, 1], [16, endpoint], [24, length], [36, interval]], true);
  }

  in(endpoint, length, interval) {
    return this.start_in(endpoint, length, interval).reply;
  }

  out(endpoint, data) {
    return this.send(1, [[16, endpoint], [24, data.length]], false, Buffer.from(data)).reply;
  }

  control(setup, data = Buffer.alloc(0)) {
    const to_host = (setup[0] & 0x80) !== 0;
    const bytes = Buffer.from(setup);
    const fields = [[12, to_host ? 1 : 0], [24, bytes.readUInt16LE(6)], [40, bytes.readUInt32BE(0)],
      [44, bytes.readUInt32BE(4)]];
    return this.send(1, fields, to_host, Buffer.from(data)).reply;
  }

  unlink(seqnum) {
    return this.send(2, [[20, seqnum]], false).reply;
  }

  close() {
    this.socket.destroy();
  }
}

/** Lines to the control port; each resolves to its answer. */
export class Control {
  static async connect(port) {
    const control = new Control();
    control.socket = connect(port, "127.0.0.1");
    control.text = "";
    control.waiting = [];
    control.socket.on("data", (chunk) => {
      control.text += chunk;
      const lines = control.text.split("\n");
      control.text = lines.pop();
      for (const line of lines) control.waiting.shift()(line);
    });
    await once(control.socket, "connect");
    return control;
  }

  async ask(line) {
    const answer = await new Promise((resolve) => {
      this.waiting.push(resolve);
      this.socket.write(`${line}\n`);
    });
    if (answer.startsWith("error")) throw new Error(answer);
    return answer === "ok" ? undefined : JSON.parse(answer.slice(3));
  }

  close() {
    this.socket.destroy();
  }
}
