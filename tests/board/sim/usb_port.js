// SPDX-License-Identifier: MIT
// RP2040's USB device controller: registers, DPRAM, and what it answers to each token (datasheet, 4.1). A host calls
// setup(), out(), in() and what follows; nothing here knows of time.
import { Block } from "./block.js";

const IRQ_USBCTRL = 5;
// Halves of a buffer control word; buffer 1's stand 16 bits higher.
const FULL = 0x8000, LAST = 0x4000, DATA1 = 0x2000, SELECTOR_RESET = 0x1000, STALL = 0x800, AVAILABLE = 0x400,
  LENGTH = 0x3ff;
const SIE_SUSPENDED = 1 << 4, SIE_RESUME = 1 << 11, SIE_CONNECTED = 1 << 16, SIE_SETUP_REC = 1 << 17,
  SIE_TRANS_COMPLETE = 1 << 18, SIE_BUS_RESET = 1 << 19, SIE_RX_OVERFLOW = 1 << 26, SIE_RX_TIMEOUT = 1 << 27,
  SIE_DATA_SEQ_ERROR = -(2 ** 31);
const WRITE_1_TO_CLEAR = 0xff0f0810 | 0; // errors, BUS_RESET, TRANS_COMPLETE, SETUP_REC, CONNECTED, RESUME, SUSPENDED
// clk_usb is slower than the processor: a buffer's other bits must stand this long before AVAILABLE is set.
const SETTLE_CYCLES = 3;

/** Packet identities of data. */
export const DATA = ["DATA0", "DATA1"];

export class UsbPort extends Block {
  constructor(chip) {
    super(chip, "USB");
    this.memory = new Uint32Array(1024);
    this.bytes = new Uint8Array(this.memory.buffer);
    this.on_attach_change = () => {}; // the pull-up goes on or off
    this.reset();
  }

  reset() {
    this.memory.fill(0);
    this.written_at = new Float64Array(32).fill(-Infinity); // buffer controls, without AVAILABLE
    this.main_control = 0;
    this.sie_control = 0;
    this.sie_status = 0;
    this.address = 0;
    this.muxing = 0;
    this.power = 0;
    this.frame = 0;
    this.completed = Array.from({ length: 32 }, () => []); // by bit of BUFF_STATUS: halves the CPU has yet to handle
    this.selector = new Uint8Array(32); // double buffering: which half is next
    this.stall_arm = 0;
    this.abort = 0;
    this.abort_done = 0;
    this.stall_nak = 0;
    this.latched = 0; // INTR bits that are latches of their own: DEV_CONN_DIS, DEV_SUSPEND, DEV_SOF
    this.inte = 0;
    this.intf = 0;
    this.scratch = new Map(); // registers without effect here
    this.was_attached = false;
    this.sequence_errors = 0;
    this.on_attach_change();
    this.update_irq();
  }

  // ---- the bus

  /** Whether the pull-up is seen by the host. */
  get attached() {
    return (this.main_control & 3) === 1 && (this.sie_control & (1 << 16)) !== 0 && (this.muxing & 1) !== 0 &&
      this.vbus_detected;
  }

  get vbus_detected() {
    return (this.power & 0xc) === 0xc;
  }

  bus_reset() {
    this.set_status(SIE_BUS_RESET | SIE_CONNECTED);
    this.sie_status &= ~SIE_SUSPENDED;
    this.update_irq();
  }

  start_of_frame(frame) {
    this.frame = frame & 0x7ff;
    this.latched |= 1 << 17;
    this.update_irq();
  }

  suspend() {
    this.latched |= 1 << 14;
    this.set_status(SIE_SUSPENDED);
  }

  resume() {
    this.latched |= 1 << 14;
    this.sie_status &= ~SIE_SUSPENDED;
    this.set_status(SIE_RESUME);
  }

  /** "ack", or undefined where it is not addressed. */
  setup(address, endpoint, bytes) {
    if (address !== this.address || endpoint !== 0) return undefined;
    this.bytes.set(bytes, 0);
    this.stall_arm = 0;
    this.set_status(SIE_SETUP_REC);
    return "ack";
  }

  /** An OUT with its data packet: "ack", "nak", "stall" or undefined. */
  out(address, endpoint, data_pid, data) {
    const index = 2 * endpoint + 1;
    const found = this.find_buffer(address, endpoint, index);
    if (typeof found !== "object") return found;
    const { control, half, buffer, word } = found;
    if (word & FULL) return this.refuse(index, control, "nak");
    if ((word & DATA1 ? 1 : 0) !== data_pid) {
      this.sequence_errors++;
      this.set_status(SIE_DATA_SEQ_ERROR);
      return "ack"; // so that the host goes on: its ACK of before was lost
    }
    if (data.length > (word & LENGTH)) {
      this.set_status(SIE_RX_OVERFLOW);
      return undefined;
    }
    this.bytes.set(data, buffer);
    this.finish(index, control, half, (word & ~(AVAILABLE | LENGTH)) | FULL | data.length);
    return "ack";
  }

  /** An IN: { pid, data }, or "nak", "stall", undefined. After data comes in_acked() or in_lost(). */
  in(address, endpoint) {
    const index = 2 * endpoint;
    const found = this.find_buffer(address, endpoint, index);
    if (typeof found !== "object") return found;
    const { control, buffer, word } = found;
    if (!(word & FULL)) return this.refuse(index, control, "nak");
    return { pid: word & DATA1 ? 1 : 0, data: this.bytes.slice(buffer, buffer + (word & LENGTH)) };
  }

  in_acked(endpoint) {
    const index = 2 * endpoint;
    const control = this.endpoint_control(endpoint, index);
    const half = control.double ? this.selector[index] : 0;
    const word = (this.memory[32 + index] >>> (16 * half)) & 0xffff;
    this.finish(index, control, half, word & ~(AVAILABLE | FULL));
  }

  in_lost() {
    this.set_status(SIE_RX_TIMEOUT);
  }

  // ---- buffers

  endpoint_control(endpoint, index) {
    if (endpoint === 0) {
      const sie = this.sie_control;
      return { enabled: true, double: (sie & (1 << 30)) !== 0, each: (sie & (1 << 29)) !== 0,
        each_two: (sie & (1 << 28)) !== 0, on_nak: (sie & (1 << 27)) !== 0, on_stall: sie < 0, address: 0x100 };
    }
    const word = this.memory[index];
    return { enabled: word >>> 31 === 1, double: (word & (1 << 30)) !== 0, each: (word & (1 << 29)) !== 0,
      each_two: (word & (1 << 28)) !== 0, on_nak: (word & (1 << 16)) !== 0, on_stall: (word & (1 << 17)) !== 0,
      address: word & 0xffc0 };
  }

  find_buffer(address, endpoint, index) {
    if (address !== this.address) return undefined;
    const control = this.endpoint_control(endpoint, index);
    if (!control.enabled) return undefined;
    const both = this.memory[32 + index];
    const armed = endpoint !== 0 || (this.stall_arm & (1 << index)) !== 0;
    if (both & STALL && armed) return this.refuse(index, control, "stall");
    const half = control.double ? this.selector[index] : 0;
    const word = (both >>> (16 * half)) & 0xffff;
    if (!(word & AVAILABLE) || this.abort & (1 << index)) return this.refuse(index, control, "nak");
    return { control, half, word, buffer: control.address + 64 * half };
  }

  refuse(index, control, answer) {
    if (answer === "nak" ? control.on_nak : control.on_stall) {
      this.stall_nak |= 1 << index;
      this.update_irq();
    }
    return answer;
  }

  finish(index, control, half, word) {
    const shift = 16 * half;
    const other = this.memory[32 + index] & ~(0xffff << shift);
    this.memory[32 + index] = other | (word << shift);
    if (control.double) this.selector[index] ^= 1;
    if (control.each || (control.each_two && half === 1)) this.completed[index].push(half);
    if (word & LAST) this.sie_status |= SIE_TRANS_COMPLETE;
    this.update_irq();
  }

  // ---- interrupts

  set_status(bits) {
    this.sie_status |= bits;
    this.update_irq();
  }

  buffer_status() {
    let bits = 0;
    for (let index = 0; index < 32; index++) if (this.completed[index].length > 0) bits |= 1 << index;
    return bits;
  }

  should_handle() {
    let bits = 0;
    for (let index = 0; index < 32; index++) if (this.completed[index][0] === 1) bits |= 1 << index;
    return bits;
  }

  raw_interrupts() {
    const status = this.sie_status;
    const from_status = (bit, interrupt) => ((status >>> bit) & 1) << interrupt;
    return this.latched | from_status(18, 3) | (this.buffer_status() !== 0 ? 1 << 4 : 0) | from_status(31, 5) |
      from_status(27, 6) | from_status(26, 7) | from_status(25, 8) | from_status(24, 9) | from_status(29, 10) |
      from_status(19, 12) | from_status(11, 15) | from_status(17, 16) | (this.abort_done ? 1 << 18 : 0) |
      (this.stall_nak ? 1 << 19 : 0);
  }

  update_irq() {
    this.chip.core.setInterrupt(IRQ_USBCTRL, ((this.raw_interrupts() & this.inte) | this.intf) !== 0);
  }

  // ---- DPRAM, as the processor sees it

  get in_reset() {
    return (this.chip.resets.held & (1 << 24)) !== 0;
  }

  read_memory(offset) {
    if (this.in_reset) this.chip.complain("USB memory is read while RESETS holds it in reset");
    return this.memory[offset >>> 2];
  }

  write_memory(offset, value) {
    if (this.in_reset) {
      this.chip.complain("USB memory is written while RESETS holds it in reset");
    } else if (offset >= 0x80 && offset < 0x100) {
      this.write_buffer_control((offset - 0x80) >>> 2, value);
    } else {
      this.memory[offset >>> 2] = value;
    }
  }

  write_buffer_control(index, value) {
    const old = this.memory[32 + index];
    const { now } = this.chip.queue;
    const both = AVAILABLE | (AVAILABLE << 16);
    const newly_available = value & both & ~old;
    if ((value ^ old) & ~both) {
      if (newly_available) this.complain_of_race();
      this.written_at[index] = now;
    } else if (newly_available && now - this.written_at[index] < SETTLE_CYCLES) {
      this.complain_of_race();
    }
    if (value & SELECTOR_RESET) this.selector[index] = 0;
    this.memory[32 + index] = value & ~SELECTOR_RESET;
  }

  complain_of_race() {
    this.chip.complain("USB: AVAILABLE is set less than a cycle of clk_usb after the buffer's other bits");
  }

  // ---- registers

  read(offset) {
    switch (offset) {
      case 0x00: return this.address;
      case 0x40: return this.main_control;
      case 0x48:
        this.latched &= ~(1 << 17);
        this.update_irq();
        return this.frame;
      case 0x4c: return this.sie_control;
      case 0x50: return this.sie_status | (this.vbus_detected ? 1 : 0);
      case 0x58: return this.buffer_status();
      case 0x5c: return this.should_handle();
      case 0x60: return this.abort;
      case 0x64: return this.abort_done;
      case 0x68: return this.stall_arm;
      case 0x70: return this.stall_nak;
      case 0x74: return this.muxing;
      case 0x78: return this.power;
      case 0x8c: return this.raw_interrupts();
      case 0x90: return this.inte;
      case 0x94: return this.intf;
      case 0x98: return (this.raw_interrupts() & this.inte) | this.intf;
      default: return offset < 0x9c ? this.scratch.get(offset) ?? 0 : this.unknown("read", offset);
    }
  }

  write(offset, value) {
    const { raw } = this;
    switch (offset) {
      case 0x00: this.address = value & 0x7f; break;
      case 0x40: this.main_control = value; break;
      case 0x4c: this.sie_control = value | 0; break;
      case 0x50: this.clear_status(raw); break;
      case 0x58: this.clear_buffer_status(raw); break;
      case 0x60:
        this.abort = value;
        this.abort_done |= value;
        break;
      case 0x64: this.abort_done &= ~raw; break;
      case 0x68: this.stall_arm = value & 3; break;
      case 0x70: this.stall_nak &= ~raw; break;
      case 0x74: this.muxing = value; break;
      case 0x78: this.power = value; break;
      case 0x90: this.inte = value & 0xfffff; break;
      case 0x94: this.intf = value & 0xfffff; break;
      default:
        if (offset >= 0x9c) this.unknown("write", offset);
        this.scratch.set(offset, value);
    }
    this.update_irq();
    this.look_at_pull_up();
  }

  clear_status(bits) {
    this.sie_status &= ~(bits & WRITE_1_TO_CLEAR & ~SIE_SUSPENDED);
    if (bits & SIE_SUSPENDED) this.latched &= ~(1 << 14);
    if (bits & SIE_CONNECTED) this.latched &= ~(1 << 13);
  }

  /** Where two buffers are done, the bit comes back for the second. */
  clear_buffer_status(bits) {
    for (let index = 0; index < 32; index++) if (bits & (1 << index)) this.completed[index].shift();
  }

  look_at_pull_up() {
    if (this.attached === this.was_attached) return;
    if (this.attached && !this.chip.usb_clock_runs()) return;
    this.was_attached = this.attached;
    this.on_attach_change();
  }
}
