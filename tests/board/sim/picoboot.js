// SPDX-License-Identifier: MIT
// The RP2040's ROM as a USB device in BOOTSEL mode: its PICOBOOT interface over the simulated flash, transfer by
// transfer. Written from the protocol's description in the datasheet (2.8.5). The mass-storage interface is only
// described: it never answers.

const MAGIC = 0x431fd10b;
const COMMAND_BYTES = 32;
const CMD = { exclusive_access: 0x01, reboot: 0x02, flash_erase: 0x03, read: 0x84, write: 0x05, exit_xip: 0x06,
  enter_cmd_xip: 0x07 };
const ARGUMENT_BYTES = { 0x01: 1, 0x02: 12, 0x03: 8, 0x84: 8, 0x05: 8, 0x06: 0, 0x07: 0 };
export const STATUS = { ok: 0, unknown_cmd: 1, invalid_cmd_length: 2, invalid_transfer_length: 3, invalid_address: 4,
  bad_alignment: 5, interleaved_write: 6, rebooting: 7, unknown_error: 8 };
const FLASH = 0x10000000, SRAM = 0x20000000, ROM_BYTES = 0x4000;
const SECTOR = 4096, PAGE = 256;
// Times of the W25Q16JV, typical; of the bus about 1 MB/s.
const ERASE_MS = 45, PROGRAM_MS = 0.4, BYTES_PER_MS = 1000;
const STORAGE_IN = 1, STORAGE_OUT = 2, OUT_ENDPOINT = 3, IN_ENDPOINT = 4;
const INTERFACE = 1;
const CYCLES_PER_MS = 125000;

export const DEVICE_DESCRIPTOR = Uint8Array.of(18, 1, 0x10, 0x01, 0, 0, 0, 64, 0x8a, 0x2e, 0x03, 0x00, 0x00, 0x01,
  1, 2, 3, 1);
const CONFIGURATION = Uint8Array.of(9, 2, 55, 0, 2, 1, 0, 0x80, 250,
  9, 4, 0, 0, 2, 0x08, 0x06, 0x50, 0, 7, 5, 0x80 | STORAGE_IN, 2, 64, 0, 0, 7, 5, STORAGE_OUT, 2, 64, 0, 0,
  9, 4, INTERFACE, 0, 2, 0xff, 0, 0, 0, 7, 5, OUT_ENDPOINT, 2, 64, 0, 0, 7, 5, 0x80 | IN_ENDPOINT, 2, 64, 0, 0);
const STRINGS = ["", "Raspberry Pi", "RP2 Boot", "E0C9125B0D9B"];

function string_descriptor(index) {
  if (index === 0) return Uint8Array.of(4, 3, 9, 4);
  if (index >= STRINGS.length) return undefined;
  const text = Buffer.from(STRINGS[index], "utf16le");
  return Uint8Array.of(2 + text.length, 3, ...text);
}

/** Answers transfers: submit() calls back with (status, data), 0 or a negative errno as Linux has them. */
export class Picoboot {
  /** on_reboot() is called after the delay that the command asks for. */
  constructor(chip, on_reboot) {
    this.chip = chip;
    this.on_reboot = on_reboot;
    this.device_descriptor = DEVICE_DESCRIPTOR;
    this.configuration = CONFIGURATION;
    this.exclusive = 0;
    this.storage_waits = new Set(); // transfers of the mass storage
    this.log = []; // commands, as [number, status]
    this.reset_interface();
  }

  reset_interface() {
    for (const { on_done } of this.waiting_in ?? []) on_done(-32);
    this.waiting_in = []; // IN transfers that wait for data
    this.ready_in = []; // packets that wait for IN transfers
    this.halted = false; // both endpoints, after an error
    this.state = "command"; // "write": its data come; "acknowledge": the host's empty packet comes
    this.status = { token: 0, code: STATUS.ok, command: 0, in_progress: 0 };
    this.busy_until = 0;
  }

  submit(request, on_done) {
    if (request.endpoint === 0) this.control(request, on_done);
    else if (request.endpoint <= STORAGE_OUT) this.storage_waits.add(on_done);
    else if (this.halted) on_done(-32);
    else if (request.to_host && request.endpoint === IN_ENDPOINT) this.take_in(request, on_done);
    else if (!request.to_host && request.endpoint === OUT_ENDPOINT) this.take_out(request.data, on_done);
    else on_done(-71);
  }

  cancel(on_done) {
    this.storage_waits.delete(on_done);
    this.waiting_in = this.waiting_in.filter((waiting) => waiting.on_done !== on_done);
  }

  // ---- endpoint 0

  control({ setup, length }, on_done) {
    const request = `${setup[0].toString(16)}:${setup[1].toString(16)}`;
    const value = setup[2] | (setup[3] << 8);
    const vendor_elsewhere = (setup[0] & 0x60) === 0x40 && setup[4] !== INTERFACE;
    if (vendor_elsewhere) return on_done(-32);
    const answer = (data) => (data === undefined ? on_done(-32) : on_done(0, data.slice(0, length)));
    switch (request) {
      case "80:6": return answer(this.descriptor(value >>> 8, value & 255));
      case "80:0": return answer(Uint8Array.of(0, 0));
      case "81:0": return answer(Uint8Array.of(0, 0));
      case "82:0": return answer(Uint8Array.of(this.halted ? 1 : 0, 0));
      case "80:8": return answer(Uint8Array.of(1));
      case "81:a": return answer(Uint8Array.of(0));
      case "a1:fe": return answer(Uint8Array.of(0)); // mass storage: one unit
      case "0:9": case "1:b": case "0:5": return on_done(0, new Uint8Array(0));
      case "2:1":
        this.halted = false;
        return on_done(0, new Uint8Array(0));
      case "41:41":
        this.reset_interface();
        return on_done(0, new Uint8Array(0));
      case "c1:42": return answer(this.status_bytes());
      default: return on_done(-32);
    }
  }

  descriptor(type, index) {
    if (type === 1) return DEVICE_DESCRIPTOR;
    if (type === 2) return CONFIGURATION;
    return type === 3 ? string_descriptor(index) : undefined;
  }

  status_bytes() {
    const bytes = new DataView(new ArrayBuffer(16));
    bytes.setUint32(0, this.status.token, true);
    bytes.setUint32(4, this.status.code, true);
    bytes.setUint8(8, this.status.command);
    bytes.setUint8(9, this.chip.queue.now < this.busy_until ? 1 : 0);
    return new Uint8Array(bytes.buffer);
  }

  // ---- bulk

  take_in(request, on_done) {
    this.waiting_in.push({ length: request.length, on_done });
    this.serve_in();
  }

  serve_in() {
    while (this.waiting_in.length > 0 && this.ready_in.length > 0) {
      const { length, on_done } = this.waiting_in.shift();
      const data = this.ready_in.shift();
      if (data.length > length) this.ready_in.unshift(data.slice(length));
      on_done(0, data.slice(0, length));
    }
  }

  /** Data for the host, or its empty acknowledgement, when the work is done. */
  send_in(data, after_ms) {
    this.busy_until = this.chip.queue.now + Math.round(after_ms * CYCLES_PER_MS);
    this.chip.queue.at(this.busy_until, () => {
      this.ready_in.push(data);
      this.serve_in();
    });
  }

  take_out(data, on_done) {
    if (this.state === "acknowledge" && data.length === 0) {
      this.state = "command";
      return on_done(0);
    }
    if (this.state === "write") return this.take_write(data, on_done);
    if (data.length === 0) return on_done(0);
    if (data.length !== COMMAND_BYTES) return this.fail(STATUS.unknown_error, on_done);
    const view = new DataView(data.buffer, data.byteOffset, data.length);
    if (view.getUint32(0, true) !== MAGIC) return this.fail(STATUS.unknown_error, on_done);
    this.command = { token: view.getUint32(4, true), number: view.getUint8(8), size: view.getUint8(9),
      length: view.getUint32(12, true), arguments: view };
    this.status = { token: this.command.token, code: STATUS.ok, command: this.command.number };
    const code = this.refusal();
    if (code !== STATUS.ok) return this.fail(code, on_done);
    on_done(0);
    return this.start();
  }

  /** The data packets of a write, in transfers of any size. */
  take_write(data, on_done) {
    this.received.push(...data);
    if (this.received.length > this.command.length) return this.fail(STATUS.invalid_transfer_length, on_done);
    on_done(0);
    if (this.received.length === this.command.length) this.do_write();
    return undefined;
  }

  fail(code, on_done) {
    this.status.code = code;
    this.log.push([this.status.command, code]);
    this.halted = true;
    this.state = "command";
    for (const waiting of this.waiting_in) waiting.on_done(-32);
    this.waiting_in = [];
    this.ready_in = [];
    on_done(-32);
  }

  // ---- commands

  argument(index) {
    return this.command.arguments.getUint32(16 + 4 * index, true);
  }

  refusal() {
    const { number, size, length } = this.command;
    if (!(number in ARGUMENT_BYTES)) return STATUS.unknown_cmd;
    if (size !== ARGUMENT_BYTES[number]) return STATUS.invalid_cmd_length;
    const moves_data = number === CMD.read || number === CMD.write;
    if (length !== (moves_data ? this.argument(1) : 0)) return STATUS.invalid_transfer_length;
    if (number === CMD.reboot && this.argument(0) !== 0) return STATUS.invalid_address; // a start in RAM: not modelled
    const has_range = moves_data || number === CMD.flash_erase;
    return has_range ? this.range_refusal(this.argument(0), this.argument(1)) : STATUS.ok;
  }

  range_refusal(address, size) {
    const flash_bytes = this.chip.flash.bytes.length;
    const in_flash = address >= FLASH && address + size <= FLASH + flash_bytes;
    const { number } = this.command;
    if (number === CMD.flash_erase) {
      if (!in_flash) return STATUS.invalid_address;
      return (address | size) % SECTOR === 0 ? STATUS.ok : STATUS.bad_alignment;
    }
    if (in_flash && number === CMD.write) return (address | size) % PAGE === 0 ? STATUS.ok : STATUS.bad_alignment;
    const in_ram = address >= SRAM && address + size <= SRAM + this.chip.sram.length;
    const in_rom = number === CMD.read && address + size <= ROM_BYTES;
    return in_flash || in_ram || in_rom ? STATUS.ok : STATUS.invalid_address;
  }

  start() {
    const { flash, rom } = this.chip;
    switch (this.command.number) {
      case CMD.exclusive_access: this.exclusive = this.command.arguments.getUint8(16); return this.done(0);
      case CMD.flash_erase: {
        const offset = this.argument(0) - FLASH;
        flash.bytes.fill(0xff, offset, offset + this.argument(1));
        return this.done((this.argument(1) / SECTOR) * ERASE_MS);
      }
      case CMD.write:
        this.received = [];
        this.state = "write";
        return undefined;
      case CMD.read: {
        const address = this.argument(0);
        const memory = address >= SRAM ? this.chip.sram : address >= FLASH ? flash.bytes : new Uint8Array(rom.buffer);
        const start = address % 0x10000000;
        this.state = "acknowledge";
        this.log.push([CMD.read, STATUS.ok]);
        return this.send_in(memory.slice(start, start + this.argument(1)), this.argument(1) / BYTES_PER_MS);
      }
      case CMD.reboot:
        this.chip.queue.at(this.chip.queue.now + Math.max(1, this.argument(2)) * CYCLES_PER_MS, this.on_reboot);
        return this.done(0);
      default: return this.done(0); // exit_xip, enter_cmd_xip
    }
  }

  do_write() {
    const address = this.argument(0);
    if (address >= SRAM) {
      this.chip.sram.set(this.received, address - SRAM);
    } else {
      const { bytes } = this.chip.flash;
      this.received.forEach((byte, index) => { bytes[address - FLASH + index] &= byte; });
    }
    this.state = "command";
    this.done((this.received.length / PAGE) * PROGRAM_MS);
  }

  done(after_ms) {
    this.log.push([this.command.number, STATUS.ok]);
    this.send_in(new Uint8Array(0), after_ms);
  }
}
