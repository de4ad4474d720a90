// SPDX-License-Identifier: MIT
// The short way to common instructions does what rp2040js' own does: registers, flags, cycles, memory.
import assert from "node:assert/strict";
import { test } from "node:test";
import { EventQueue } from "../sim/event_queue.js";
import { StockCore } from "../sim/quick_core.js";
import { Bench } from "./bench.js";

const CODE = 0x20000100, DATA = 0x20001000;
const ROUNDS = 60_000;

/** Numbers that repeat with their seed (xorshift, Marsaglia 2003). */
function generator(seed) {
  let x = seed;
  return () => {
    x ^= x << 13;
    x ^= x >>> 17;
    x ^= x << 5;
    return x >>> 0;
  };
}

function state_of(core) {
  return [...core.registers, core.N, core.Z, core.C, core.V, core.cycles].join();
}

test(`${ROUNDS} instructions at random, the short and the long way`, () => {
  const { core } = new Bench().chip;
  const next = generator(42);
  const edges = [0, 1, 2, 0x7fffffff, 0x80000000, 0xffffffff, 0xfffffffe, 0x7ffffffe];
  const queue = new EventQueue();
  let short_ways = 0;
  let long_ways = 0;
  core.executeInstruction = () => {
    long_ways++;
    StockCore.prototype.executeInstruction.call(core);
  };
  for (let round = 0; round < ROUNDS; round++) {
    const opcode = next() & 0xffff;
    const group = opcode >>> 11;
    const stops = (opcode >>> 8) === 0xde || (opcode >>> 8) === 0xdf; // UDF, SVC
    if (stops || group > 0b11100 || group === 0b10110 || group === 0b10111) continue; // and wide ones, and the stack's
    const memory = (group >= 0b01010 && group <= 0b10001) || group === 0b11000 || group === 0b11001;
    const registers = Array.from({ length: 13 }, () => (next() & 3 ? next() : edges[next() & 7]));
    // Addresses: a base in RAM, aligned, and small offsets.
    if (memory) for (let at = 0; at < 8; at++) registers[at] = DATA + ((next() & 0xff) << 2);
    if (memory && group <= 0b01011) registers[(opcode >>> 6) & 7] = (next() & 0xff) << 2;
    if (group === 0b01010 || group === 0b01011) {
      if (((opcode >>> 6) & 7) === ((opcode >>> 3) & 7)) continue; // base and offset in one register
    }
    const flags = next();
    const prepare = () => {
      registers.forEach((value, at) => { core.registers[at] = value; });
      core.registers[13] = DATA + 0x800;
      core.registers[14] = CODE | 1;
      core.registers[15] = CODE;
      [core.N, core.Z, core.C, core.V] = [0, 1, 2, 3].map((bit) => (flags & (1 << bit)) !== 0);
      core.cycles = 0;
      core.interruptsUpdated = false;
      for (let at = 0; at < 1024; at++) core.ram32[0x400 + at] = at * 0x01010101;
      core.ram16[(CODE - 0x20000000) >>> 1] = opcode;
    };
    const only_some = round % 50 === 0; // memory is compared now and then: it is slow
    prepare();
    queue.limit = 1; // one instruction
    const before = long_ways;
    core.run(queue);
    if (long_ways === before) short_ways++;
    const quick = state_of(core);
    const quick_memory = only_some ? core.ram32.slice(0x400, 0x800).join() : "";
    prepare();
    StockCore.prototype.executeInstruction.call(core);
    assert.equal(quick, state_of(core), `opcode ${opcode.toString(16)}`);
    if (only_some) assert.equal(quick_memory, core.ram32.slice(0x400, 0x800).join(), `opcode ${opcode.toString(16)}`);
  }
  assert.ok(short_ways > 20_000 && long_ways > 2_000, `${short_ways} the short way, ${long_ways} the long one`);
});
