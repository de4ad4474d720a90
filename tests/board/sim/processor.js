// SPDX-License-Identifier: MIT
// The processor: rp2040js' instructions, with our own memory map, interrupt controller, sleep and faults.
import { QuickCore } from "./quick_core.js";

const RAM_BYTES = 264 * 1024;
const ENTRY_CYCLES = 15; // stacking, after the instruction that was interrupted
const RETURN_CYCLES = 10; // unstacking, beside the cycles of the BX or POP
const HARD_FAULT = 3;
const SYSTICK = 15;
const LOWEST = 4; // priority of thread mode

/** The processor touched what is not there, or not aligned. */
export class BusFault extends Error {}

export class Processor extends QuickCore {
  constructor(rp, chip) {
    super(rp);
    this.chip = chip;
    this.lines = 0; // interrupt requests as the peripherals hold them
    this.active = []; // exception numbers being served
    this.sleep_on_exit = false;
    this.stopped = false; // by a test, or locked up
    this.attach_memory(rp.sram);
  }

  /** Starts at an address with a stack, as after the ROM. */
  start(address, stack) {
    this.SP = stack;
    this.LR = 0;
    this.PC = address & ~1;
  }

  fault(what, address) {
    throw new BusFault(`${what} 0x${(address >>> 0).toString(16)} at pc 0x${((this.PC - 2) >>> 0).toString(16)}`);
  }

  // ---- memory map

  readUint32(address) {
    const offset = (address >>> 0) - 0x20000000;
    if (offset >= 0 && offset < RAM_BYTES && (address & 3) === 0) return this.ram32[offset >>> 2];
    return this.read_elsewhere(address >>> 0);
  }

  readUint16(address) {
    const offset = (address >>> 0) - 0x20000000;
    if (offset >= 0 && offset < RAM_BYTES && (address & 1) === 0) return this.ram16[offset >>> 1];
    if (address & 1) this.fault("unaligned read of", address);
    const word = this.read_elsewhere((address & ~3) >>> 0);
    return address & 2 ? word >>> 16 : word & 0xffff;
  }

  readUint8(address) {
    const offset = (address >>> 0) - 0x20000000;
    if (offset >= 0 && offset < RAM_BYTES) return this.ram8[offset];
    return (this.read_elsewhere((address & ~3) >>> 0) >>> (8 * (address & 3))) & 0xff;
  }

  read_elsewhere(address) {
    if (address & 3) this.fault("unaligned read of", address);
    const { chip } = this;
    if (address >= 0x10000000 && address < 0x14000000) return chip.ssi.read_flash(address & 0xffffff);
    if (address < 0x4000) return chip.rom[address >>> 2];
    if (address >= 0xd0000000 && address < 0xd0000200) return chip.sio.readUint32(address & 0xfff) >>> 0;
    if (address >>> 12 === 0xe000e) return chip.ppb.readUint32(address & 0xfff) >>> 0;
    if (address >= 0x50100000 && address < 0x50101000) return chip.usb.read_memory(address & 0xfff);
    const peripheral = this.rp2040.peripherals[(address >>> 14) << 2];
    if (peripheral) return peripheral.readUint32(address & 0xfff) >>> 0;
    return this.fault("read of", address);
  }

  writeUint32(address, value) {
    const offset = (address >>> 0) - 0x20000000;
    if (offset >= 0 && offset < RAM_BYTES && (address & 3) === 0) this.ram32[offset >>> 2] = value;
    else this.write_elsewhere(address >>> 0, value >>> 0);
  }

  writeUint16(address, value) {
    const offset = (address >>> 0) - 0x20000000;
    if (offset >= 0 && offset < RAM_BYTES && (address & 1) === 0) this.ram16[offset >>> 1] = value;
    else if (address & 1) this.fault("unaligned write of", address);
    else this.write_narrow(address >>> 0, 0xffff, ((value & 0xffff) * 0x10001) >>> 0);
  }

  writeUint8(address, value) {
    const offset = (address >>> 0) - 0x20000000;
    if (offset >= 0 && offset < RAM_BYTES) this.ram8[offset] = value;
    else this.write_narrow(address >>> 0, 0xff, ((value & 0xff) * 0x1010101) >>> 0);
  }

  /** The bus repeats narrow data over the word; registers take the whole word, only memory knows byte lanes. */
  write_narrow(address, mask, repeated) {
    if (address >= 0x50100000 && address < 0x50101000) {
      const lanes = (mask << (8 * (address & 3))) >>> 0;
      const old = this.chip.usb.read_memory(address & 0xffc);
      this.chip.usb.write_memory(address & 0xffc, ((old & ~lanes) | (repeated & lanes)) >>> 0);
    } else {
      this.write_elsewhere((address & ~3) >>> 0, repeated);
    }
  }

  write_elsewhere(address, value) {
    if (address & 3) this.fault("unaligned write of", address);
    const { chip } = this;
    if (address >= 0xd0000000 && address < 0xd0000200) {
      chip.sio.writeUint32(address & 0xfff, value);
    } else if (address >>> 12 === 0xe000e) {
      chip.ppb.writeUint32(address & 0xfff, value);
    } else if (address >= 0x50100000 && address < 0x50101000) {
      chip.usb.write_memory(address & 0xfff, value);
    } else {
      const peripheral = this.rp2040.peripherals[(address >>> 14) << 2];
      if (!peripheral) this.fault("write of", address);
      peripheral.writeUint32Atomic(address & 0xfff, value, (address >>> 12) & 3);
    }
  }

  // ---- interrupts

  /** A peripheral's request: an edge makes it pending, and so does one that is still held when its handler ends. */
  setInterrupt(irq, value) {
    const bit = 1 << irq;
    if (value) {
      if (this.lines & bit) return;
      this.lines |= bit;
      this.pendingInterrupts |= bit;
      this.interruptsUpdated = true;
    } else {
      this.lines &= ~bit;
    }
  }

  clear_pending(bits) {
    this.pendingInterrupts &= ~bits;
    for (let irq = 0; irq < 32; irq++) {
      if ((bits & this.lines) & (1 << irq) && !this.active.includes(16 + irq)) this.pendingInterrupts |= 1 << irq;
    }
    this.interruptsUpdated = true;
  }

  /** The most urgent pending exception that is more urgent than `limit`; 0: none. */
  most_urgent(limit) {
    if (this.pendingNMI) return limit > -2 ? 2 : 0;
    const wanted = this.pendingInterrupts & this.enabledInterrupts;
    if (wanted === 0 && !(this.pendingSVCall || this.pendingPendSV || this.pendingSystick)) return 0;
    for (let priority = 0; priority < limit; priority++) {
      if (this.pendingSVCall && priority === this.svCallPriority) return 11;
      if (this.pendingPendSV && priority === this.pendSVPriority) return 14;
      if (this.pendingSystick && priority === this.systickPriority) return SYSTICK;
      const level = wanted & this.interruptPriorities[priority];
      if (level) return 16 + 31 - Math.clz32(level & -level);
    }
    return 0;
  }

  running_priority() {
    return this.IPSR === 0 ? LOWEST : this.exceptionPriority(this.IPSR);
  }

  get vectPending() {
    return this.most_urgent(LOWEST);
  }

  checkForInterrupts() {
    this.interruptsUpdated = false;
    const running = this.running_priority();
    const number = this.most_urgent(this.PM ? Math.min(0, running) : running);
    if (number === 0) return false;
    if (number === 2) this.pendingNMI = false;
    else if (number === 11) this.pendingSVCall = false;
    else if (number === 14) this.pendingPendSV = false;
    else if (number === SYSTICK) this.pendingSystick = false;
    else this.pendingInterrupts &= ~(1 << (number - 16));
    this.exceptionEntry(number);
    return true;
  }

  /** Ends a sleep if something is pending that would interrupt; masking by PRIMASK does not keep it asleep. */
  wake_if_due() {
    if (this.stopped || this.most_urgent(this.running_priority()) === 0) return false;
    this.waiting = false;
    this.interruptsUpdated = true;
    return true;
  }

  exceptionEntry(number) {
    this.active.push(number);
    super.exceptionEntry(number);
    this.cycles += ENTRY_CYCLES;
    this.interruptsUpdated = true;
    if (this.chip.on_exception) this.chip.on_exception(number);
  }

  exceptionReturn(kind) {
    const number = this.active.pop();
    super.exceptionReturn(kind);
    this.cycles += RETURN_CYCLES;
    if (number >= 16 && this.lines & (1 << (number - 16))) this.pendingInterrupts |= 1 << (number - 16);
    this.interruptsUpdated = true;
    if (this.sleep_on_exit && this.active.length === 0) this.waiting = true;
  }

  /** What the processor does with a bus fault or an undefined instruction: HardFault; in HardFault it locks up. */
  hard_fault(why) {
    this.chip.complain(`HardFault: ${why}`);
    this.cycles += 1;
    if (this.active.includes(HARD_FAULT) || this.active.includes(2)) {
      this.stopped = true;
      this.chip.complain("the processor is locked up");
    } else {
      this.exceptionEntry(HARD_FAULT);
    }
  }
}
