// SPDX-License-Identifier: MIT
// Exports running simulated boards over USB/IP, so that a real kernel has them at its virtual USB ports.
//   node usbip_server.js [--port N] [--control-port N] [--boards N] [FIRMWARE]
// Board i has the bus id "1-(i + 1)" and the unique id of board 0 plus i. An import waits until its board shows a
// device; when the device goes (unplugged, reset, in the boot ROM), the connection ends, and the next import waits for
// the next one. Without FIRMWARE the flashes are blank, so the boot ROM shows itself. Ports default to free ones; a
// line of JSON on standard output tells which. Lines on the control port: see usbip/control_lines.js. Only on 127.0.0.1.
import { createServer } from "node:net";
import { createInterface } from "node:readline";
import { fileURLToPath } from "node:url";
import { parseArgs } from "node:util";
import { do_line } from "./usbip/control_lines.js";
import { LiveBoard } from "./usbip/live_board.js";
import { import_reply, list_reply, Reader, submit_reply, unlink_reply } from "./usbip/wire.js";

const ECONNRESET = -104;

/** One connection: a list, or an import and then its transfers. */
class Connection {
  constructor(server, socket) {
    this.server = server;
    this.socket = socket;
    this.reader = new Reader();
    this.pending = new Map(); // seqnum -> on_done
    this.live = undefined;
    this.closed = false;
    socket.setNoDelay(true);
    socket.on("data", (chunk) => this.received(chunk));
    socket.on("error", () => {});
    socket.on("close", () => this.close());
  }

  received(chunk) {
    this.reader.push(chunk);
    this.live?.keep_up();
    for (let message = this.reader.next(); message !== undefined; message = this.reader.next()) {
      if (message.kind === "unknown") {
        this.socket.destroy();
        return;
      }
      this[message.kind](message);
    }
    this.live?.hurry();
  }

  list() {
    const devices = this.server.boards.flatMap((live, index) =>
      (live.device?.device_descriptor ? [this.server.described(index, live.device)] : []));
    this.socket.end(list_reply(devices));
  }

  import({ busid }) {
    const index = this.server.boards.findIndex((_, at) => `1-${at + 1}` === busid);
    if (index < 0) {
      this.socket.end(import_reply(undefined));
      return;
    }
    this.server.boards[index].when_ready((device) => {
      if (this.closed) return;
      this.live = this.server.boards[index];
      this.device = device;
      this.server.importers.get(index)?.socket.destroy(); // one at a time: the last one wins
      this.server.importers.set(index, this);
      this.reader.imported = true;
      this.socket.write(import_reply(this.server.described(index, device)));
    });
  }

  submit(request) {
    const on_done = (status, data) => {
      this.pending.delete(request.seqnum);
      if (!this.closed) this.socket.write(submit_reply(request, status, data));
    };
    this.pending.set(request.seqnum, on_done);
    this.device.submit(request, on_done);
  }

  unlink(request) {
    const on_done = this.pending.get(request.unlinked);
    if (on_done !== undefined) {
      this.pending.delete(request.unlinked);
      this.device.cancel(on_done);
    }
    this.socket.write(unlink_reply(request, on_done === undefined ? 0 : ECONNRESET));
  }

  close() {
    if (this.closed) return;
    this.closed = true;
    for (const on_done of this.pending.values()) this.device.cancel(on_done);
    this.pending.clear();
  }
}

export class UsbipServer {
  constructor(boards) {
    this.boards = boards;
    this.importers = new Map();
    boards.forEach((live, index) => {
      live.on_gone = () => {
        const importer = this.importers.get(index);
        if (importer === undefined) return;
        this.importers.delete(index);
        importer.pending.clear(); // what is pending has been called back by the bus
        importer.socket.destroy();
      };
    });
    this.server = createServer((socket) => new Connection(this, socket));
    this.control = createServer((socket) => {
      createInterface({ input: socket }).on("line", (line) => {
        const say = (text) => socket.writable && socket.write(`${text}\n`);
        say(do_line(boards, line, () => this.close(), say));
      });
      socket.on("error", () => {});
    });
  }

  described(index, { device_descriptor, configuration }) {
    return { busid: `1-${index + 1}`, number: index + 2, device_descriptor, configuration };
  }

  /** Resolves to { port, control_port }. */
  async listen(port = 0, control_port = 0) {
    const open = (server, wanted) => new Promise((resolve, reject) => {
      server.once("error", reject);
      server.listen(wanted, "127.0.0.1", () => resolve(server.address().port));
    });
    const ports = { port: await open(this.server, port), control_port: await open(this.control, control_port) };
    for (const live of this.boards) live.start();
    return ports;
  }

  close() {
    for (const live of this.boards) live.stop();
    for (const importer of this.importers.values()) importer.socket.destroy();
    this.server.close();
    this.control.close();
  }
}

/** Boards with power, and this firmware if there is one. */
export function make_boards(count, firmware) {
  return Array.from({ length: count }, (_, index) => {
    const unique_id = [0xe6, 0x60, 0x58, 0x38, 0x83, 0x12, 0x34, 0x56 + index];
    const live = new LiveBoard({ unique_id, seed: index + 1 });
    if (firmware !== undefined) live.flash(firmware);
    live.board.adc_mv(0, 1500);
    live.board.chip.power_on();
    return live;
  });
}

async function main() {
  const { values, positionals } = parseArgs({ allowPositionals: true, options: {
    "port": { type: "string", default: "0" }, "control-port": { type: "string", default: "0" },
    "boards": { type: "string", default: "1" } } });
  const server = new UsbipServer(make_boards(Number(values.boards), positionals[0]));
  const ports = await server.listen(Number(values.port), Number(values["control-port"]));
  console.log(JSON.stringify({ ...ports, pid: process.pid }));
  for (const signal of ["SIGINT", "SIGTERM"]) process.on(signal, () => { server.close(); process.exit(0); });
}

if (process.argv[1] === fileURLToPath(import.meta.url)) await main();
