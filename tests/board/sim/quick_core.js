// SPDX-License-Identifier: MIT
// rp2040js' processor with a short way to the instructions that programs in RAM are mostly made of. rp2040js finds an
// instruction by trying one after the other; here a switch finds the common ones, and the rest goes the long way.
// model_tests/processor.test.js holds both ways together.
import { RP2040 } from "rp2040js";

export const StockCore = new RP2040().core.constructor; // the package does not export it by name

const RAM = 0x20000000, RAM_BYTES = 264 * 1024;
const WRAP = 2 ** 32;
const PC = 15, SP = 13;
const WIDTH_MASKS = [3, 1, 0, 0, 3, 1, 0, 1]; // address bits that must be 0, by operation of by_registers()
const LONG_WAY = 0xffff; // an opcode that is not among the common ones

export class QuickCore extends StockCore {
  /** Memory that instructions are fetched from: views of the same bytes. */
  attach_memory(sram) {
    this.ram8 = sram;
    this.ram16 = new Uint16Array(sram.buffer);
    this.ram32 = new Uint32Array(sram.buffer);
  }

  /** Runs until cycle queue.limit, a sleep or a stop; queue.now is set before anything that looks at the time. */
  run(queue) {
    const r = this.registers;
    const { ram8, ram16, ram32 } = this;
    do {
      const at = r[PC] - RAM;
      if (this.interruptsUpdated) {
        queue.now = this.cycles;
        this.checkForInterrupts();
        continue;
      }
      const opcode = at >= 0 && at < RAM_BYTES ? ram16[at >>> 1] : LONG_WAY;
      r[PC] += 2;
      this.cycles += 1;
      switch (opcode >>> 11) {
        case 0b00000: { // LSLS rd, rm, #imm
          const imm = (opcode >>> 6) & 31;
          const from = r[(opcode >>> 3) & 7];
          if (imm !== 0) this.C = ((from >>> (32 - imm)) & 1) !== 0;
          this.set_flags(r[opcode & 7] = from << imm);
          continue;
        }
        case 0b00001: { // LSRS; 0 means 32
          const imm = (opcode >>> 6) & 31;
          const from = r[(opcode >>> 3) & 7];
          this.C = ((from >>> (imm === 0 ? 31 : imm - 1)) & 1) !== 0;
          this.set_flags(r[opcode & 7] = imm === 0 ? 0 : from >>> imm);
          continue;
        }
        case 0b00010: { // ASRS; 0 means 32
          const imm = (opcode >>> 6) & 31 || 32;
          const from = r[(opcode >>> 3) & 7] | 0;
          this.C = ((from >>> (imm - 1)) & 1) !== 0;
          this.set_flags(r[opcode & 7] = imm === 32 ? from >> 31 : from >> imm);
          continue;
        }
        case 0b00011: { // ADDS, SUBS rd, rn, rm or #imm3
          const operand = opcode & 0x400 ? (opcode >>> 6) & 7 : r[(opcode >>> 6) & 7];
          const from = r[(opcode >>> 3) & 7];
          r[opcode & 7] = opcode & 0x200 ? this.subtract(from, operand) : this.add(from, operand);
          continue;
        }
        case 0b00100: this.set_flags(r[(opcode >>> 8) & 7] = opcode & 0xff); continue; // MOVS
        case 0b00101: this.subtract(r[(opcode >>> 8) & 7], opcode & 0xff); continue; // CMP
        case 0b00110: r[(opcode >>> 8) & 7] = this.add(r[(opcode >>> 8) & 7], opcode & 0xff); continue; // ADDS
        case 0b00111: r[(opcode >>> 8) & 7] = this.subtract(r[(opcode >>> 8) & 7], opcode & 0xff); continue; // SUBS
        case 0b01000:
          if (this.data_processing(opcode)) continue;
          break;
        case 0b01001: { // LDR rt, [pc, #imm]
          const from = ((r[PC] + 2) & ~3) + ((opcode & 0xff) << 2) - RAM;
          if (from < 0 || from >= RAM_BYTES) break;
          r[(opcode >>> 8) & 7] = ram32[from >>> 2];
          this.cycles += 1;
          continue;
        }
        case 0b01010: case 0b01011: { // loads and stores at rn + rm
          const where = r[(opcode >>> 3) & 7] + r[(opcode >>> 6) & 7];
          const place = (where >= WRAP ? where - WRAP : where) - RAM;
          if (place < 0 || place >= RAM_BYTES || !this.by_registers(opcode, place)) break;
          this.cycles += 1;
          continue;
        }
        case 0b01100: case 0b10010: { // STR
          const on_stack = opcode >>> 15;
          const to = (on_stack ? r[SP] + ((opcode & 0xff) << 2)
                               : r[(opcode >>> 3) & 7] + ((opcode >>> 4) & 0x7c)) - RAM;
          if (to < 0 || to >= RAM_BYTES || (to & 3) !== 0) break;
          ram32[to >>> 2] = r[on_stack ? (opcode >>> 8) & 7 : opcode & 7];
          this.cycles += 1;
          continue;
        }
        case 0b01101: case 0b10011: { // LDR
          const on_stack = opcode >>> 15;
          const from = (on_stack ? r[SP] + ((opcode & 0xff) << 2)
                                 : r[(opcode >>> 3) & 7] + ((opcode >>> 4) & 0x7c)) - RAM;
          if (from < 0 || from >= RAM_BYTES || (from & 3) !== 0) break;
          r[on_stack ? (opcode >>> 8) & 7 : opcode & 7] = ram32[from >>> 2];
          this.cycles += 1;
          continue;
        }
        case 0b01110: { // STRB
          const to = r[(opcode >>> 3) & 7] + ((opcode >>> 6) & 31) - RAM;
          if (to < 0 || to >= RAM_BYTES) break;
          ram8[to] = r[opcode & 7];
          this.cycles += 1;
          continue;
        }
        case 0b01111: { // LDRB
          const from = r[(opcode >>> 3) & 7] + ((opcode >>> 6) & 31) - RAM;
          if (from < 0 || from >= RAM_BYTES) break;
          r[opcode & 7] = ram8[from];
          this.cycles += 1;
          continue;
        }
        case 0b11010: case 0b11011: { // B with a condition; UDF and SVC are the last two
          const condition = (opcode >>> 8) & 15;
          if (condition >= 14) break;
          if (this.holds(condition)) {
            r[PC] += (((opcode & 0xff) << 24) >> 23) + 2;
            this.cycles += 1;
          }
          continue;
        }
        case 0b11100: // B
          r[PC] += (((opcode & 0x7ff) << 21) >> 20) + 2;
          this.cycles += 1;
          continue;
      }
      r[PC] -= 2;
      this.cycles -= 1;
      queue.now = this.cycles;
      this.executeInstruction();
    } while (this.cycles < queue.limit && !this.waiting && !this.stopped);
  }

  /** A load or store in RAM, at that offset; false where it is not aligned. */
  by_registers(opcode, place) {
    const r = this.registers;
    const rt = opcode & 7;
    const operation = (opcode >>> 9) & 7;
    if (place & WIDTH_MASKS[operation]) return false;
    switch (operation) {
      case 0: this.ram32[place >>> 2] = r[rt]; break; // STR
      case 1: this.ram16[place >>> 1] = r[rt]; break; // STRH
      case 2: this.ram8[place] = r[rt]; break; // STRB
      case 3: r[rt] = (this.ram8[place] << 24) >> 24; break; // LDRSB
      case 4: r[rt] = this.ram32[place >>> 2]; break; // LDR
      case 5: r[rt] = this.ram16[place >>> 1]; break; // LDRH
      case 6: r[rt] = this.ram8[place]; break; // LDRB
      default: r[rt] = (this.ram16[place >>> 1] << 16) >> 16; break; // LDRSH
    }
    return true;
  }

  /** Of the group 010000 to 010001: the common ones; false for the others. */
  data_processing(opcode) {
    const r = this.registers;
    const rd = opcode & 7;
    const other = r[(opcode >>> 3) & 7];
    switch (opcode >>> 6) {
      case 0b0100000000: this.set_flags(r[rd] = r[rd] & other); return true; // ANDS
      case 0b0100000001: this.set_flags(r[rd] = r[rd] ^ other); return true; // EORS
      case 0b0100001000: this.set_flags(r[rd] & other); return true; // TST
      case 0b0100001001: r[rd] = this.subtract(0, other); return true; // RSBS
      case 0b0100001010: this.subtract(r[rd], other); return true; // CMP
      case 0b0100001100: this.set_flags(r[rd] = r[rd] | other); return true; // ORRS
      case 0b0100001101: this.set_flags(r[rd] = Math.imul(r[rd], other)); return true; // MULS
      case 0b0100001110: this.set_flags(r[rd] = r[rd] & ~other); return true; // BICS
      case 0b0100001111: this.set_flags(r[rd] = ~other); return true; // MVNS
      case 0b0100011000: case 0b0100011001: case 0b0100011010: case 0b0100011011: { // MOV between any two
        const to = ((opcode >>> 4) & 8) | rd;
        const from = (opcode >>> 3) & 15;
        if (to >= SP || from >= SP) return false;
        r[to] = r[from];
        return true;
      }
      default: return false;
    }
  }

  set_flags(result) {
    this.N = (result | 0) < 0;
    this.Z = (result | 0) === 0;
  }

  add(a, b) {
    const result = (a + b) | 0;
    this.N = result < 0;
    this.Z = result === 0;
    this.C = a + b > 0xffffffff;
    this.V = ((a ^ result) & (b ^ result)) < 0;
    return result;
  }

  subtract(a, b) {
    const result = (a - b) | 0;
    this.N = result < 0;
    this.Z = result === 0;
    this.C = a >= b;
    this.V = ((a ^ b) & (a ^ result)) < 0;
    return result;
  }

  holds(condition) {
    let result;
    switch (condition >>> 1) {
      case 0: result = this.Z; break;
      case 1: result = this.C; break;
      case 2: result = this.N; break;
      case 3: result = this.V; break;
      case 4: result = this.C && !this.Z; break;
      case 5: result = this.N === this.V; break;
      default: result = this.N === this.V && !this.Z; break;
    }
    return condition & 1 ? !result : result;
  }
}
