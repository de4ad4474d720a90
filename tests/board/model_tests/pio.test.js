// SPDX-License-Identifier: MIT
// PIO against tables counted by hand from the datasheet (RP2040, 3.2 to 3.5). Cycle 0 is that of a machine's first
// instruction; an instruction of cycle n moves its pin at n + 1, and a state machine sees an input two cycles old.
import assert from "node:assert/strict";
import { test } from "node:test";
import { ADDR, Bench, CTRL, EXECCTRL, FDEBUG, FLEVEL, FROM, FSTAT, in_, INSTR, irq, IRQ, jmp, JMP, mov, MOV_TO, NOP,
  out, pinctrl, PIO0, PIO1, pull, push, RXF0, set, SET_TO, SHIFTCTRL, TO, TXF0, wait, WAIT } from "./bench.js";

const OUT_PIN = 2;
const SET_PIN = pinctrl({ set_count: 1, set_base: OUT_PIN });
const high = (delay = 0) => set(SET_TO.pins, 1, delay);
const low = (delay = 0) => set(SET_TO.pins, 0, delay);
const AUTOPULL = 0x20000, AUTOPUSH = 0x10000, OUT_RIGHT = 0x80000;

// name, program, cycles, expected edges, options
const TABLE = [
  ["SET, and delays after it", [high(3), low(1)], 14, [[0, 1], [4, 0], [6, 1], [10, 0], [12, 1]]],
  ["JMP x-- is done x + 1 times, each with its delay", [set(SET_TO.x, 3), high(), jmp(2, JMP.x_dec, 1), low(31)], 20,
    [[1, 1], [10, 0]]],
  ["JMP !x, x != y, !y", [set(SET_TO.x, 0), set(SET_TO.y, 2), jmp(4, JMP.not_x), high(), jmp(6, JMP.x_ne_y), NOP,
    high(), jmp(7, JMP.always)], 12, [[4, 1]]],
  ["JMP y-- falls through at 0 and wraps it to ffffffff",
    [set(SET_TO.y, 0), jmp(3, JMP.y_dec), high(), jmp(5, JMP.y_dec), jmp(4),
    low(), jmp(6)], 12, [[2, 1], [4, 0]]],
  ["JMP pin sees the input two cycles late", [jmp(3, JMP.pin), jmp(0), NOP, high(), jmp(4)], 20, [[9, 1]],
    { execctrl: 5 << 24, inputs: [[6, 5, 1]] }],
  ["JMP pin does not see it one cycle late", [jmp(3, JMP.pin), jmp(0), NOP, high(), jmp(4)], 20, [[11, 1]],
    { execctrl: 5 << 24, inputs: [[7, 5, 1]] }],
  ["WAIT gpio: the first cycle with the input two cycles old is its last", [wait(1, WAIT.gpio, 5), high(), jmp(2)], 20,
    [[13, 1]], { inputs: [[10, 5, 1]] }],
  ["WAIT's delay comes after the wait",
    [wait(1, WAIT.gpio, 5, 4), high(), jmp(2)], 30, [[17, 1]], { inputs: [[10, 5, 1]] }],
  ["WAIT pin counts from IN_BASE, for 0 too", [wait(1, WAIT.pin, 1), high(), wait(0, WAIT.pin, 1), low(), jmp(4)], 30,
    [[7, 1], [17, 0]],
    { pinctrl: pinctrl({ set_count: 1, set_base: OUT_PIN, in_base: 4 }), inputs: [[4, 5, 1], [14, 5, 0]] }],
  ["wrap costs nothing, a JMP one cycle",
    [high(), low(), jmp(0)], 9, [[0, 1], [1, 0], [3, 1], [4, 0], [6, 1], [7, 0], [9, 1]]],
  ["wrap elsewhere than at the end",
    [low(), high(), low(1), NOP], 7, [[1, 1], [2, 0], [4, 1], [5, 0], [7, 1]], { wrap: [1, 2] }],
  ["PULL, MOV and a counted pulse: low y + 5, high x + 2, as the firmware's",
    [pull(), mov(MOV_TO.y, FROM.osr), jmp(2, JMP.y_dec),
    pull(), mov(MOV_TO.x, FROM.osr), irq(0x10, {}, 0x10), jmp(6, JMP.x_dec, 0x10)], 200,
  [[105, 1], [127, 0]], { pinctrl: pinctrl({ side_count: 1, side_base: OUT_PIN }), fifo: [100, 20] }],
  ["side-set acts in an instruction's first cycle, also when it stalls",
    [NOP | (0x10 << 8), pull({}, 0), NOP | (0x10 << 8), jmp(3)], 9,
    [[0, 1], [1, 0]], { pinctrl: pinctrl({ side_count: 1, side_base: OUT_PIN }) }],
  ["optional side-set: enable bit first, two bits used, three left for delay",
    [NOP | (0b11_010 << 8), NOP | (0b00_001 << 8), NOP | (0b10_000 << 8), jmp(3)], 12, [[0, 1], [5, 0]],
    { pinctrl: pinctrl({ side_count: 2, side_base: OUT_PIN }), execctrl: 0x40000000 }],
  ["side-set on directions: the pin is let go and its pull-down wins",
    [NOP | (0x10 << 8), NOP, jmp(2, 0, 0x10)], 6, [[0, 1], [1, 0], [2, 1]],
    { pinctrl: pinctrl({ side_count: 1, side_base: OUT_PIN }), execctrl: 0x20000000, all_high: true }],
  ["side-set wins over SET on one pin, in the same cycle",
    [set(SET_TO.pins, 0, 0x10), set(SET_TO.pins, 1), jmp(2, 0, 0)], 6,
    [[0, 1], [1, 0]], { pinctrl: pinctrl({ side_count: 1, side_base: OUT_PIN, set_count: 1, set_base: OUT_PIN }) }],
  ["MOV pins, inverted and reversed",
    [set(SET_TO.x, 0), mov(MOV_TO.pins, FROM.x, 1), mov(MOV_TO.pins, FROM.x), set(SET_TO.y, 1),
    mov(MOV_TO.pins, FROM.y, 2), mov(MOV_TO.pins, FROM.y), jmp(6)], 9, [[1, 1], [2, 0], [5, 1]],
  { pinctrl: pinctrl({ out_count: 1, out_base: OUT_PIN }) }],
  ["MOV pc and OUT pc",
    [set(SET_TO.x, 3), mov(MOV_TO.pc, FROM.x), high(), pull(), out(TO.pc, 5), high(), low(), high(), jmp(8)], 12,
    [[4, 1]], { fifo: [7] }],
  ["OUT exec does the word in the next cycle, with its delay",
    [pull(), out(TO.exec, 16), low(), jmp(3)], 12, [[2, 1], [5, 0]],
    { fifo: [set(SET_TO.pins, 1, 2)] }],
  ["OUT exec has no delay of its own", [pull(), out(TO.exec, 16, 7), low(), jmp(3)], 12, [[2, 1], [3, 0]],
    { fifo: [set(SET_TO.pins, 1)] }],
  ["MOV exec, of a jump", [pull(), mov(MOV_TO.exec, FROM.osr), high(), low(), high(), jmp(5)], 12, [[3, 1]],
    { fifo: [jmp(4)] }],
  ["OUT with autopull: one cycle for the first word, none for those that wait in the FIFO", [out(TO.pins, 1)], 11,
    [[1, 1], [2, 0], [3, 1], [8, 0]],
    { pinctrl: pinctrl({ out_count: 1, out_base: OUT_PIN }), shiftctrl: (AUTOPULL | OUT_RIGHT | (4 << 25)) >>> 0,
      fifo: [0b1101, 0b0111] }],
  ["divider 2.5: ticks 0, 2, 5, 7, 10",
    [high(), low()], 12, [[0, 1], [2, 0], [5, 1], [7, 0], [10, 1], [12, 0]], { clkdiv: 0x00028000 }],
  ["divider 3: everything takes three times as long, delays too",
    [high(1), low()], 18, [[0, 1], [6, 0], [9, 1], [15, 0], [18, 1]],
    { clkdiv: 0x00030000 }],
  ["IRQ wait: raised in its first cycle, on when the other side has cleared it",
    [irq(2, { wait_for: 1 }, 2), high(), jmp(2)], 30, [[14, 1]],
    { at_cycle: [10, (bench) => bench.write(PIO0 + IRQ, 1 << 2)] }],
];

for (const [name, program, cycles, expected, options = {}] of TABLE) {
  test(name, () => {
    const bench = new Bench();
    bench.pio_outputs(0, OUT_PIN);
    bench.load(program, { pinctrl: SET_PIN, ...options });
    if (options.all_high) { // the latch is high and the direction in
      bench.chip.pio[0].write_pins(OUT_PIN, 1, 1);
      bench.chip.pio[0].write_directions(OUT_PIN, 1, 0);
      bench.chip.pio[0].commit(bench.cycle);
      bench.chip.pins.watch(OUT_PIN);
      bench.run(5);
    }
    for (const word of options.fifo ?? []) bench.write(PIO0 + TXF0, word);
    const start = bench.enable();
    for (const [cycle, pin, level] of options.inputs ?? []) {
      bench.chip.queue.at(start + cycle, () => bench.chip.pins.drive_pin(pin, level));
    }
    if (options.at_cycle) bench.chip.queue.at(start + options.at_cycle[0], () => options.at_cycle[1](bench));
    bench.run_to(start + cycles);
    assert.deepEqual(bench.edges(OUT_PIN, start + 1), expected);
    assert.deepEqual([...bench.chip.complaints], []);
  });
}

/** A bench with one machine set up and enabled; `start` is the cycle of its first instruction. */
function running(program, options = {}, fifo = []) {
  const bench = new Bench();
  bench.load(program, options);
  for (const word of fifo) bench.write(PIO0 + TXF0, word);
  return { bench, start: bench.enable() };
}

test("IN shifts either way; autopush at its threshold", () => {
  const right = running([set(SET_TO.x, 0b101), in_(FROM.x, 3), in_(FROM.null, 5), in_(FROM.x, 8), push(), jmp(5)]);
  right.bench.run(10);
  assert.equal(right.bench.read(PIO0 + RXF0) >>> 16, 0b00000101_00000101);
  const left = running([set(SET_TO.x, 0b101), in_(FROM.x, 3), in_(FROM.x, 5), jmp(1)],
    { shiftctrl: AUTOPUSH | (8 << 20) });
  left.bench.run(8);
  assert.equal(left.bench.read(PIO0 + RXF0), 0b101_00101);
  assert.equal(left.bench.read(PIO0 + RXF0), 0b101_00101);
  assert.equal(left.bench.read(PIO0 + FSTAT) & 0x100, 0x100, "empty again");
});

test("IN pins turns by IN_BASE; MOV isr and osr reset their counters", () => {
  const { bench } = running([in_(FROM.pins, 4), push(), mov(MOV_TO.isr, FROM.null, 1), push({ iffull: 1 }), jmp(4)],
    { pinctrl: pinctrl({ in_base: 5 }), shiftctrl: 0 });
  bench.chip.pins.drive_pin(6, 1);
  bench.write(PIO0 + CTRL, 0x11);
  bench.write(PIO0 + INSTR, jmp(0));
  bench.run(20);
  const words = [bench.read(PIO0 + RXF0), bench.read(PIO0 + RXF0)];
  assert.ok(words.includes(0b0010), `${words}`);
  assert.equal(bench.chip.pio[0].machines[0].isr, 0xffffffff, "not full: MOV reset the count");
});

test("OUT shifts either way, PULL ifempty looks at the threshold, JMP !osre", () => {
  const { bench } = running(
    [pull(), out(TO.x, 8), pull({ ifempty: 1 }), out(TO.y, 8), jmp(6, JMP.not_osre), jmp(5), jmp(6)],
    { shiftctrl: 16 << 25 }, [0x11223344, 0x55667788]);
  bench.run(3);
  assert.equal(bench.read(PIO0 + FLEVEL) & 15, 1, "the conditional PULL took nothing at 8 of 16 bits");
  bench.run(10);
  const [machine] = bench.chip.pio[0].machines;
  assert.deepEqual([machine.x, machine.y, machine.pc], [0x11, 0x22, 5]);
});

test("PULL without block takes x from an empty FIFO; PUSH without block drops and says so", () => {
  const { bench } = running(
    [set(SET_TO.x, 9), pull({ block: 0 }), mov(MOV_TO.isr, FROM.osr), push({ block: 0 }), jmp(2)]);
  bench.run(40);
  assert.equal(bench.read(PIO0 + FLEVEL), 4 << 4);
  assert.equal(bench.read(PIO0 + RXF0), 9);
  assert.equal(bench.read(PIO0 + FDEBUG) & 0x01000001, 1, "RXSTALL, not TXSTALL");
});

test("a stalled PULL goes on the cycle after the word was written, and TXSTALL tells of it", () => {
  const bench = new Bench();
  bench.pio_outputs(0, OUT_PIN);
  bench.load([pull(), high(), jmp(2)], { pinctrl: SET_PIN });
  const start = bench.enable();
  bench.run_to(start + 1000);
  assert.equal(bench.read(PIO0 + FDEBUG), 1 << 24);
  bench.write(PIO0 + FDEBUG, 1 << 24);
  assert.equal(bench.read(PIO0 + FDEBUG), 1 << 24, "it still stalls");
  bench.write(PIO0 + TXF0, 1);
  bench.run(5);
  assert.deepEqual(bench.edges(OUT_PIN, start + 1000), [[3, 1]]); // PULL at 1, SET at 2, the pin at 3
  bench.write(PIO0 + FDEBUG, 1 << 24);
  assert.equal(bench.read(PIO0 + FDEBUG), 0);
});

test("PUSH and IN with autopush stall on a full FIFO and lose nothing", () => {
  const { bench } = running([mov(MOV_TO.isr, FROM.x), push(), jmp(0, JMP.x_dec)]);
  bench.run(200);
  assert.equal(bench.read(PIO0 + FLEVEL) >>> 4 & 15, 4);
  assert.equal(bench.read(PIO0 + FDEBUG), 1);
  const words = [];
  for (let count = 0; count < 8; count++) {
    words.push(bench.read(PIO0 + RXF0));
    bench.run(10);
  }
  assert.deepEqual(words, [0, 0xffffffff, 0xfffffffe, 0xfffffffd, 0xfffffffc, 0xfffffffb, 0xfffffffa, 0xfffffff9]);
  const autopush = running([in_(FROM.x, 32), jmp(0, JMP.x_dec)], { shiftctrl: AUTOPUSH });
  autopush.bench.run(100);
  const taken = [];
  for (let count = 0; count < 6; count++) {
    taken.push(autopush.bench.read(PIO0 + RXF0));
    autopush.bench.run(10);
  }
  assert.deepEqual(taken, [0, 0xffffffff, 0xfffffffe, 0xfffffffd, 0xfffffffc, 0xfffffffb]);
});

test("FIFOs: level, full, TXOVER, RXUNDER, join to eight, interrupts by level", () => {
  const bench = new Bench();
  bench.write(PIO0 + 0x12c, 0x10); // IRQ0_INTE: TXNFULL of machine 0
  assert.equal(bench.chip.core.lines & (1 << 7), 1 << 7);
  for (let word = 0; word < 5; word++) bench.write(PIO0 + TXF0, word);
  assert.equal(bench.chip.core.lines & (1 << 7), 0);
  assert.equal(bench.read(PIO0 + FSTAT) & 0x00010000, 0x00010000);
  assert.equal(bench.read(PIO0 + FDEBUG), 1 << 16);
  bench.read(PIO0 + RXF0);
  assert.equal(bench.read(PIO0 + FDEBUG), (1 << 16) | (1 << 8));
  bench.write(PIO0 + SHIFTCTRL, 0x400c0000);
  assert.equal(bench.read(PIO0 + FLEVEL), 0, "joining empties");
  for (let word = 0; word < 9; word++) bench.write(PIO0 + TXF0, word);
  assert.equal(bench.read(PIO0 + FLEVEL), 8);
});

test("IRQ and WAIT irq between machines: seen in the next cycle, cleared by the one that waited; rel counts on", () => {
  const bench = new Bench();
  bench.pio_outputs(0, OUT_PIN);
  bench.load([NOP, NOP, irq(0x10 | 3), jmp(3)], { machine: 2 }); // rel: 3 + 2 -> flag 1
  bench.load([wait(1, WAIT.irq, 1), high(), jmp(12)], { at: 10, machine: 0, pinctrl: SET_PIN });
  const start = bench.enable(0b101);
  bench.run(2);
  assert.equal(bench.read(PIO0 + IRQ), 0);
  bench.run(10);
  assert.deepEqual(bench.edges(OUT_PIN, start + 1), [[4, 1]]); // IRQ at 2, seen at 3, SET at 4
  assert.equal(bench.read(PIO0 + IRQ), 0);
});

test("machines of both blocks start in one cycle through a gate, INOVER of a pin that nobody drives", () => {
  const bench = new Bench();
  const pins = [2, 3, 4, 5, 6, 7, 8, 9];
  for (const [index, pin] of pins.entries()) {
    const block = index >> 2;
    bench.pio_outputs(block, pin);
    bench.load([wait(1, WAIT.gpio, 23), high(), jmp(2)],
      { block: block ? PIO1 : PIO0, machine: index & 3, pinctrl: pinctrl({ set_count: 1, set_base: pin }) });
  }
  bench.write(0x40014004 + 8 * 23, 0x1f | (2 << 16));
  bench.enable(15, PIO0);
  bench.run(6);
  bench.enable(15, PIO1);
  bench.run(100);
  bench.write(0x40014004 + 8 * 23, 0x1f | (3 << 16));
  const opened = bench.cycle;
  bench.run(20);
  // In at 1, seen at 3, SET at 4, out at 5.
  for (const pin of pins) assert.deepEqual(bench.edges(pin, opened), [[5, 1]]);
});

test("INSTR is done at once, also by a stopped machine; RESTART and the program counter", () => {
  const bench = new Bench();
  bench.pio_outputs(0, OUT_PIN);
  bench.load([NOP, wait(1, WAIT.gpio, 9), jmp(2)], { pinctrl: SET_PIN });
  bench.write(PIO0 + INSTR, high());
  assert.deepEqual(bench.edges(OUT_PIN, bench.cycle), [[2, 1]]);
  assert.equal(bench.read(PIO0 + ADDR), 0);
  const start = bench.enable();
  bench.run_to(start + 50);
  assert.equal(bench.read(PIO0 + ADDR), 1);
  bench.write(PIO0 + INSTR, low());
  bench.run(5);
  assert.equal(bench.read(PIO0 + ADDR), 1, "it waits as before");
  bench.write(PIO0 + INSTR, pull());
  bench.run(5);
  assert.equal(bench.read(PIO0 + EXECCTRL) >>> 31, 1, "EXEC_STALLED");
  bench.write(PIO0 + CTRL, 0x11);
  bench.run(5);
  assert.equal(bench.read(PIO0 + EXECCTRL) >>> 31, 0);
  bench.write(PIO0 + INSTR, jmp(2));
  bench.run(5);
  assert.equal(bench.read(PIO0 + ADDR), 2);
  assert.equal(bench.read(PIO0 + 0x3c), 0);
  assert.equal(bench.read(PIO0 + 0x40), 1 << OUT_PIN);
});

test("INPUT_SYNC_BYPASS lets an input in at once", () => {
  const bench = new Bench();
  bench.pio_outputs(0, OUT_PIN);
  bench.write(PIO0 + 0x38, 1 << 5);
  bench.load([wait(1, WAIT.gpio, 5), high(), jmp(2)], { pinctrl: SET_PIN });
  const start = bench.enable();
  bench.chip.queue.at(start + 10, () => bench.chip.pins.drive_pin(5, 1));
  bench.run(20);
  assert.deepEqual(bench.edges(OUT_PIN, start + 1), [[12, 1]]); // seen at 11, the cycle after it came
});

test("MOV status follows the FIFO level", () => {
  const bench = new Bench();
  bench.pio_outputs(0, OUT_PIN);
  bench.load([mov(MOV_TO.pins, FROM.status)], { pinctrl: pinctrl({ out_count: 1, out_base: OUT_PIN }), execctrl: 2 });
  const start = bench.enable();
  bench.chip.queue.at(start + 4, () => bench.write(PIO0 + TXF0, 0));
  bench.chip.queue.at(start + 8, () => bench.write(PIO0 + TXF0, 0));
  bench.run(20);
  assert.deepEqual(bench.edges(OUT_PIN, start + 1), [[0, 1], [9, 0]]);
});

// The same program stepped cycle by cycle and with its loops skipped must do the same at the same cycle.
function measured(program, pulse, divider, skips) {
  const bench = new Bench();
  const [machine] = bench.chip.pio[0].machines;
  let steps = 0;
  const step = machine.step.bind(machine);
  machine.step = (cycle) => { steps++; step(cycle); };
  if (!skips) machine.look_for_loop = () => {};
  bench.pio_outputs(0, OUT_PIN);
  bench.load(program, { pinctrl: SET_PIN, execctrl: 14 << 24, clkdiv: divider });
  const start = bench.enable();
  const { queue, pins } = bench.chip;
  for (const [cycle, pin, level] of pulse) queue.at(start + cycle, () => pins.drive_pin(pin, level));
  bench.run(pulse.at(-1)[0] + 5000);
  machine.settle(bench.cycle);
  return { x: machine.x, y: machine.y, pc: machine.pc, edges: bench.edges(OUT_PIN, start), steps };
}

const MEASURE = [mov(MOV_TO.x, FROM.null, 1), wait(1, WAIT.gpio, 14), jmp(3, JMP.x_dec), jmp(2, JMP.pin), high(),
  jmp(5)];
const COUNT = [set(SET_TO.x, 31), mov(MOV_TO.x, FROM.x, 2), mov(MOV_TO.y, FROM.null, 1), jmp(4, JMP.y_dec),
  jmp(3, JMP.x_dec, 2), high(), jmp(6)];
const POLL = [jmp(2, JMP.pin), jmp(0), high(), jmp(3, JMP.pin, 3), low(), jmp(5)];

for (const [name, program] of [["measures a pulse", MEASURE], ["polls a pin", POLL]]) {
  test(`a loop of jumps that ${name} is skipped over without a difference`, () => {
    for (const divider of [0x10000, 0x28000, 0x30000]) {
      for (const width of [1, 2, 3, 50, 51, 52, 53, 1000, 12345]) {
        const pulse = [[40, 14, 1], [41, 7, 1], [40 + Math.ceil(width / 2), 7, 0], [40 + width, 14, 0],
          [41 + width, 7, 1]];
        const { steps: slow_steps, ...slow } = measured(program, pulse, divider, false);
        const { steps: quick_steps, ...quick } = measured(program, pulse, divider, true);
        assert.deepEqual(quick, slow, `width ${width} divider ${divider}`);
        assert.ok(quick_steps < 120, `${quick_steps} of ${slow_steps} steps`);
      }
    }
  });
}

test("a long count takes as few steps as a short one and ends in its cycle", () => {
  const program = [pull(), mov(MOV_TO.x, FROM.osr), jmp(2, JMP.x_dec, 1), high(), jmp(4)];
  const long = running(program, { pinctrl: SET_PIN }, [4_000_000_000]);
  long.bench.pio_outputs(0, OUT_PIN);
  long.bench.run(8_000_000_100);
  assert.deepEqual(long.bench.edges(OUT_PIN, long.start + 1), [[2 + 2 * 4_000_000_001, 1]]);
  const halfway = running(COUNT, { pinctrl: SET_PIN });
  halfway.bench.run(3000);
  const [machine] = halfway.bench.chip.pio[0].machines;
  halfway.bench.read(PIO0 + ADDR);
  assert.equal(0xf8000000 - machine.x, Math.floor((2999 - 4) / 4) + 1, "read in mid-count: x as it is in that cycle");
});

test("a pulse train of PIO and one of PWM keep step for a hundred periods", () => {
  const bench = new Bench();
  const PWM = 0x40050000;
  bench.write(0x40014004 + 8 * 0, 4); // GPIO0: PWM slice 0, channel A
  bench.chip.pins.watch(0);
  bench.write(PWM + 0x04, 22 << 4); // divider 22
  bench.write(PWM + 0x10, 63129); // TOP
  bench.write(PWM + 0x0c, 5000);
  bench.write(PWM + 0x00, 1);
  bench.pio_outputs(0, OUT_PIN);
  bench.load([pull(), mov(MOV_TO.y, FROM.osr), jmp(2, JMP.y_dec), pull(), mov(MOV_TO.x, FROM.osr), irq(0x10, {}, 0x10),
    jmp(6, JMP.x_dec, 0x10)], { pinctrl: pinctrl({ side_count: 1, side_base: OUT_PIN }) });
  const [high_cycles, period] = [5000 * 22, 63130 * 22];
  bench.enable();
  const feed = () => {
    while (bench.chip.pio[0].machines[0].tx.length < 3) {
      bench.write(PIO0 + TXF0, period - high_cycles - 5);
      bench.write(PIO0 + TXF0, high_cycles - 2);
    }
  };
  for (let count = 0; count < 101; count++) {
    feed();
    bench.run(period);
  }
  const rises = (pin) => bench.edges(pin, 0).filter(([, level]) => level === 1).map(([cycle]) => cycle).slice(0, 100);
  const falls = (pin) => bench.edges(pin, 0).filter(([, level]) => level === 0).map(([cycle]) => cycle).slice(0, 100);
  const pio = rises(OUT_PIN);
  assert.equal(pio.length, 100);
  for (let count = 1; count < 100; count++) assert.equal(pio[count] - pio[count - 1], period);
  for (const [index, cycle] of falls(OUT_PIN).entries()) assert.equal(cycle - pio[index], high_cycles);
  const pwm = rises(0);
  for (let count = 2; count < 100; count++) assert.equal(pwm[count] - pwm[count - 1], period);
});
