// SPDX-License-Identifier: MIT
// Processor, interrupts, SysTick, TIMER, watchdog, ADC, pins, resets, flash and ROM against RP2040's datasheet.
import assert from "node:assert/strict";
import { test } from "node:test";
import { Chip } from "../sim/chip.js";
import { crc32 } from "../sim/rom.js";
import { Bench } from "./bench.js";
import { Thumb } from "./thumb.js";

const CODE = 0x20000400, HANDLERS = 0x20000800, STACK = 0x20010000, NOTES = 0x20020000;
const SYST_CSR = 0xe000e010, SYST_RVR = 0xe000e014, SYST_CVR = 0xe000e018;
const TIMER = 0x40054000, WATCHDOG = 0x40058000, ADC = 0x4004c000, IO_BANK0 = 0x40014000, PADS = 0x4001c000;
const SIO = 0xd0000000, SSI = 0x18000000, PSM = 0x40010000, CLOCKS = 0x40008000;

/** 12 MHz crystal, 48 MHz of PLL_USB for the ADC, ticks of 1 us. */
function start_clocks(bench) {
  bench.write(0x40024000, 0xfabaa0);
  bench.write(CLOCKS + 0x30, 2);
  bench.write(0x4002c008, 100);
  bench.write(0x4002c004, 0);
  bench.write(0x4002c00c, (5 << 16) | (5 << 12));
  bench.write(CLOCKS + 0x60, 0x800);
  bench.write(WATCHDOG + 0x2c, 0x200 | 12);
}

/** Lets a program run in RAM. handlers: exception number -> Thumb. */
function run_program(bench, program, handlers = {}) {
  const { chip } = bench;
  let at = HANDLERS;
  for (const [number, handler] of Object.entries(handlers)) {
    chip.core.writeUint32(0x20000000 + 4 * number, handler.place(chip, at));
    at += 0x80;
  }
  chip.core.VTOR = 0x20000000;
  chip.core.start(program.place(chip, CODE), STACK);
  chip.core.stopped = false;
  chip.core.waiting = false;
}

/** A handler that stores `value` at NOTES and moves the pointer in r7 on. */
const noting = (value, middle = (thumb) => thumb) =>
  middle(new Thumb().movs(0, value).str(0, 7).adds(7, 4)).bx_lr();

const notes = (bench, count) => Array.from({ length: count }, (_, index) => bench.read(NOTES + 4 * index));

test("SysTick counts every cycle, wraps after reload + 1, and says so once", () => {
  const bench = new Bench();
  bench.write(SYST_RVR, 999);
  bench.write(SYST_CVR, 5);
  assert.equal(bench.read(SYST_CVR), 0, "any write clears");
  bench.write(SYST_CSR, 5);
  bench.run(1);
  assert.equal(bench.read(SYST_CVR), 999);
  bench.run(400);
  assert.equal(bench.read(SYST_CVR), 599);
  bench.run(599);
  assert.equal(bench.read(SYST_CVR), 0);
  assert.equal(bench.read(SYST_CSR), 0x10005);
  assert.equal(bench.read(SYST_CSR), 5);
  bench.run(1);
  assert.equal(bench.read(SYST_CVR), 999);
  bench.run(123_456_789);
  assert.equal(bench.read(SYST_CVR), (999 - (123_456_789 % 1000) + 1000) % 1000);
});

test("SysTick in a program: 13 cycles between two loads with 10 NOPs; it goes on in a sleep", () => {
  const bench = new Bench();
  start_clocks(bench);
  bench.write(SYST_RVR, 0xffffff);
  bench.write(SYST_CSR, 5);
  bench.write(TIMER + 0x38, 1);
  bench.write(TIMER + 0x10, 1000);
  bench.write(0xe000e100, 1);
  run_program(bench, new Thumb().load(1, SYST_CVR).load(7, NOTES).cpsid().ldr(2, 1).nop(10).ldr(3, 1).wfi().ldr(4, 1)
    .str(2, 7).str(3, 7, 4).str(4, 7, 8).label("end").branch("end"));
  const begin = bench.cycle;
  bench.run_to(begin + 130_000);
  const [first, second, third] = notes(bench, 3);
  assert.equal(first - second, 12, "2 of the load, 10 NOPs");
  const slept = second - third;
  assert.ok(Math.abs(slept - 125_000) < 100, `${slept}`);
});

test("SysTick's interrupt comes every reload + 1 cycles to a sleeping processor", () => {
  const bench = new Bench();
  const cycles = [];
  bench.chip.on_exception = () => cycles.push(bench.cycle);
  bench.write(SYST_RVR, 12_499);
  bench.write(SYST_CSR, 7);
  run_program(bench, new Thumb().label("sleep").wfi().branch("sleep"), { 15: new Thumb().bx_lr() });
  bench.run(125_100);
  assert.equal(cycles.length, 10);
  for (let count = 1; count < 10; count++) assert.equal(cycles[count] - cycles[count - 1], 12_500);
});

test("interrupts: by priority, then by number; one of higher priority interrupts, equals wait", () => {
  const bench = new Bench();
  bench.write(0xe000e400, 0x40_80_80_c0); // 0: 3, 1: 2, 2: 2, 3: 1
  bench.write(0xe000e100, 15);
  const pend = (thumb, interrupts) => thumb.load(1, 0xe000e200).movs(0, interrupts).str(0, 1);
  const note = (thumb, value) => thumb.movs(0, value).str(0, 7).adds(7, 4);
  run_program(bench, pend(new Thumb().load(7, NOTES).cpsid(), 7).cpsie().nop().label("end").branch("end"),
    { 16: noting(10), 17: noting(11, (thumb) => note(pend(thumb, 8).nop(2), 21)), 18: noting(12), 19: noting(13) });
  bench.run(500);
  assert.deepEqual(notes(bench, 6), [11, 13, 21, 12, 10, 0]);
});

test("a masked interrupt ends WFI, is taken at cpsie; a held request comes again, one that is gone stays pending", () => {
  const bench = new Bench();
  bench.write(0xe000e100, 1 << 5);
  run_program(bench, new Thumb().load(7, NOTES).cpsid().wfi().movs(0, 1).str(0, 7).adds(7, 4).cpsie().nop()
    .movs(0, 3).str(0, 7).adds(7, 4).label("end").branch("end"), { 21: noting(2) });
  bench.run(1000);
  assert.deepEqual(notes(bench, 1), [0], "asleep");
  const held = bench.cycle;
  bench.chip.core.setInterrupt(5, true);
  bench.chip.queue.at(held + 60, () => bench.chip.core.setInterrupt(5, false));
  bench.run(300);
  assert.deepEqual(notes(bench, 2), [1, 2]);
  const served = notes(bench, 40).filter((note) => note === 2).length;
  assert.ok(served >= 2 && served < 5, `served ${served} times while it was held for 60 cycles`);
  bench.write(0xe000e280, 1 << 5); // ICPR
  bench.write(0xe000e180, 1 << 5);
  bench.chip.core.setInterrupt(5, true);
  bench.chip.core.setInterrupt(5, false);
  assert.equal(bench.read(0xe000e200), 1 << 5);
  bench.write(0xe000e280, 1 << 5);
  assert.equal(bench.read(0xe000e200), 0);
});

test("WFI does not sleep where something masked is pending already", () => {
  const bench = new Bench();
  bench.write(0xe000e100, 1 << 5);
  run_program(bench, new Thumb().load(7, NOTES).cpsid().load(1, 0xe000e200).movs(0, 1 << 5).str(0, 1).nop(4).wfi()
    .movs(0, 1).str(0, 7).label("end").branch("end"), { 21: noting(2) });
  bench.run(200);
  assert.deepEqual(notes(bench, 1), [1]);
});

test("a bus fault is a HardFault, and one more in its handler stops the processor", () => {
  const bench = new Bench();
  run_program(bench, new Thumb().load(7, NOTES).load(0, 0x60000000).ldr(1, 0).label("end").branch("end"),
    { 3: new Thumb().movs(0, 9).str(0, 7).ldr(1, 7, 1 << 2).load(2, 0x20000001).ldr(1, 2).bx_lr() });
  bench.run(200);
  assert.deepEqual(notes(bench, 1), [9]);
  assert.equal(bench.chip.core.stopped, true);
  assert.equal(bench.chip.complaints.size, 3);
});

test("TIMER counts microseconds once the tick runs; alarms at their cycle; 64 bits read as one", () => {
  const bench = new Bench();
  bench.run(125 * 50);
  assert.equal(bench.read(TIMER + 0x28), 0, "no tick yet");
  start_clocks(bench);
  const begin = bench.cycle;
  bench.write(TIMER + 0x38, 2);
  bench.write(TIMER + 0x14, 700);
  bench.run(125 * 700 - 1);
  assert.equal(bench.read(TIMER + 0x34), 0);
  assert.equal(bench.read(TIMER + 0x20), 2);
  bench.run(1);
  assert.equal(bench.read(TIMER + 0x34), 2);
  assert.equal(bench.chip.core.lines & 2, 2);
  bench.write(TIMER + 0x34, 2);
  assert.equal(bench.chip.core.lines & 2, 0);
  assert.equal(bench.read(TIMER + 0x28), Math.floor((bench.cycle - begin) / 125));
  bench.write(TIMER + 0x04, 0xfffffffe);
  bench.write(TIMER + 0x00, 6);
  assert.deepEqual([bench.read(TIMER + 0x0c), bench.read(TIMER + 0x08)], [0xfffffffe, 6]);
  bench.run(250);
  assert.deepEqual([bench.read(TIMER + 0x0c), bench.read(TIMER + 0x08)], [0, 7]);
});

/** A flash that boots and spins. */
function flash_with(program) {
  const image = new Uint8Array(256);
  image.set(program.bytes(0x20041f00));
  new DataView(image.buffer).setUint32(252, crc32(image.subarray(0, 252)), true);
  return image;
}

test("watchdog: 200 ms by LOAD 400000; pins fall in that cycle; scratch and reason stay, the rest forgets", () => {
  const chip = new Chip();
  chip.flash.load(flash_with(new Thumb().label("end").branch("end")));
  chip.pins.watch(6);
  chip.power_on();
  assert.equal(chip.state, "running");
  const bench = Object.assign(Object.create(Bench.prototype), { chip });
  chip.core.stopped = true;
  bench.write(0x4000f000, 0x01ffffff);
  start_clocks(bench);
  bench.write(PSM + 8, 0x1fffc);
  bench.write(IO_BANK0 + 4 + 8 * 6, 5);
  bench.write(SIO + 0x24, 1 << 6);
  bench.write(SIO + 0x14, 1 << 6);
  bench.pio_outputs(1, 9);
  bench.write(PADS + 4 + 4 * 9, 0x5a); // its pull is up, too
  chip.pio[1].write_pins(9, 1, 1);
  chip.pio[1].commit(bench.cycle);
  bench.write(WATCHDOG + 0x0c, 0x1234);
  bench.write(WATCHDOG + 0x04, 400_000);
  bench.write(WATCHDOG, 0x40000000);
  const begin = bench.cycle;
  bench.run(12_500_000);
  assert.equal(bench.read(WATCHDOG) & 0xffffff, 200_000);
  bench.write(WATCHDOG + 0x04, 400_000);
  bench.run(24_999_999);
  assert.equal(chip.resets_seen.length, 1);
  assert.equal(chip.pins.read(6), 1);
  bench.run(2);
  assert.deepEqual(chip.resets_seen.slice(1), [{ cycle: begin + 37_500_000, cause: "watchdog" }]);
  assert.deepEqual(bench.edges(6, begin), [[1, 1], [37_500_000, 0]]);
  assert.deepEqual(bench.edges(9, begin), [[1, 1], [37_500_000, 0]]);
  chip.core.stopped = true;
  assert.deepEqual([bench.read(WATCHDOG + 8), bench.read(WATCHDOG + 0x0c)], [1, 0x1234]);
  assert.equal(bench.read(0x4000c000), 0x01ffffff & ~0x240, "everything is in reset again");
  chip.power_on();
  assert.deepEqual([bench.read(WATCHDOG + 8), bench.read(WATCHDOG + 0x0c)], [0, 0]);
});

test("watchdog without PSM_WDSEL resets nothing, and that is told", () => {
  const bench = new Bench();
  start_clocks(bench);
  bench.write(WATCHDOG + 0x04, 2000);
  bench.write(WATCHDOG, 0x40000000);
  bench.run(125_010);
  assert.equal(bench.chip.resets_seen.length, 0);
  assert.match([...bench.chip.complaints.keys()].join(), /PSM_WDSEL/);
});

test("ADC: free running at 20 kS/s, one FIFO interrupt a sample, values of their time; OVER when nobody reads", () => {
  const bench = new Bench();
  const { chip } = bench;
  start_clocks(bench);
  chip.adc_inputs[0] = (time_ns) => (time_ns < 3e6 ? 1650 : 825);
  bench.write(ADC + 0x10, 2399 << 8);
  bench.write(ADC + 0x08, 1 | (1 << 24)); // before INTE: an empty FIFO reaches a threshold of 0
  bench.write(ADC + 0x18, 1);
  bench.write(0xe000e100, 1 << 22);
  const seen = [];
  chip.on_exception = (number) => {
    assert.equal(number, 38);
    seen.push([bench.cycle, bench.read(ADC + 0x0c)]);
  };
  bench.write(ADC, 1 | 8);
  const begin = bench.cycle;
  run_program(bench, new Thumb().label("sleep").wfi().branch("sleep"), { 38: new Thumb().bx_lr() });
  bench.run(12_500_000);
  assert.equal(seen.length, 2000);
  assert.ok(seen[0][0] - begin >= 250 && seen[0][0] - begin < 270, "2 us of conversion");
  for (let count = 2; count < 2000; count++) assert.equal(seen[count][0] - seen[count - 1][0], 6250);
  assert.equal(seen[59][1], 2048);
  assert.equal(seen[61][1], 1024);
  chip.core.stopped = true;
  bench.run(6250 * 6);
  const status = bench.read(ADC + 0x08);
  assert.deepEqual([(status >>> 16) & 15, status & 0xf00], [4, 0xa00]);
  bench.write(ADC + 0x08, (1 << 11) | 1 | (1 << 24));
  assert.equal(bench.read(ADC + 0x08) & 0x800, 0);
  assert.deepEqual([...chip.complaints], []);
});

test("ADC: one conversion, round robin, FIFO of eight bits", () => {
  const bench = new Bench();
  start_clocks(bench);
  bench.chip.adc_inputs[1] = 3300;
  bench.chip.adc_inputs[3] = 1000;
  bench.write(ADC, 1 | 4 | (1 << 12));
  assert.equal(bench.read(ADC) & 0x100, 0, "busy");
  bench.run(250);
  assert.equal(bench.read(ADC) & 0x100, 0x100);
  assert.equal(bench.read(ADC + 4), 4095);
  bench.write(ADC + 8, 3);
  bench.write(ADC, 1 | 8 | (1 << 12) | (0b01010 << 16));
  bench.run(4 * 250 + 10);
  bench.write(ADC, 1);
  assert.deepEqual([1, 2, 3, 4].map(() => bench.read(ADC + 0x0c)), [255, 77, 255, 77]);
});

test("pins: overrides of output, enable and input; pulls; the pad's own enables", () => {
  const bench = new Bench();
  const { pins } = bench.chip;
  const ctrl = (pin, value) => bench.write(IO_BANK0 + 4 + 8 * pin, value);
  pins.watch(6);
  ctrl(6, 5);
  bench.write(SIO + 0x24, 1 << 6);
  bench.write(SIO + 0x14, 1 << 6);
  assert.equal(pins.read(6), 1);
  ctrl(6, 5 | (2 << 8)); // OUTOVER low
  assert.equal(pins.read(6), 0);
  ctrl(6, 5 | (3 << 8));
  assert.equal(pins.read(6), 1);
  ctrl(6, 5 | (1 << 8)); // inverted
  assert.equal(pins.read(6), 0);
  ctrl(6, 5 | (3 << 8) | (2 << 12)); // not enabled: the pull-down of reset wins
  assert.equal(pins.read(6), 0);
  bench.write(PADS + 4 + 4 * 6, 0x48); // pull-up
  assert.equal(pins.read(6), 1);
  assert.deepEqual(bench.edges(6, bench.cycle).map(([cycle]) => cycle), [1, 1, 1, 1, 1]);
  ctrl(7, 5);
  pins.drive_pin(7, 1);
  assert.equal(bench.read(SIO + 4) & (1 << 7), 1 << 7);
  bench.write(PADS + 4 + 4 * 7, 0); // input disabled
  assert.equal(bench.read(SIO + 4) & (1 << 7), 0);
  ctrl(7, 5 | (3 << 16)); // INOVER high
  assert.equal(bench.read(SIO + 4) & (1 << 7), 1 << 7);
});

test("pins: an edge interrupts, stays until it is cleared; a level while it lasts; a wire carries both", () => {
  const bench = new Bench();
  const { pins } = bench.chip;
  bench.write(IO_BANK0 + 0x104, 1 << (4 * 6 + 3)); // PROC0_INTE1: GP14 rising
  pins.drive_pin(14, 1);
  assert.equal(bench.chip.core.lines & (1 << 13), 1 << 13);
  pins.drive_pin(14, 0);
  assert.equal(bench.read(IO_BANK0 + 0x124), 8 << 24);
  bench.write(IO_BANK0 + 0xf4, 8 << 24);
  assert.equal(bench.chip.core.lines & (1 << 13), 0);
  bench.write(IO_BANK0 + 0x104, 1 << (4 * 6)); // level low
  assert.equal(bench.chip.core.lines & (1 << 13), 1 << 13);
  bench.write(IO_BANK0 + 4 + 8 * 2, 5);
  bench.write(SIO + 0x24, 1 << 2);
  pins.connect(2, 14);
  bench.write(SIO + 0x14, 1 << 2);
  assert.equal(pins.read(14), 1);
  assert.equal(bench.chip.core.lines & (1 << 13), 0);
});

test("RESETS: what is put back forgets; touching it is told", () => {
  const bench = new Bench();
  bench.write(0x50200000 + 0xd0, 0x400c0000);
  bench.write(0x4000e000, 1 << 10);
  assert.equal(bench.read(0x4000c008) & (1 << 10), 0);
  bench.write(0x50200000 + 0x10, 5);
  assert.match([...bench.chip.complaints.keys()].join(), /PIO0 is written while RESETS holds it/);
  bench.write(0x4000f000, 1 << 10);
  assert.equal(bench.read(0x50200000 + 0xd0), 0x000c0000);
});

test("flash by SSI: identity, unique number and data, byte by byte", () => {
  const bench = new Bench();
  bench.chip.flash.load([1, 2, 3, 4, 5, 6, 7, 8]);
  bench.write(SSI + 8, 0);
  bench.write(SSI + 0, 0x00070000);
  bench.write(SSI + 0x14, 8);
  bench.write(SSI + 8, 1);
  const exchange = (...bytes) => {
    bench.write(0x4001800c, 2 << 8); // chip select low
    for (const byte of bytes) bench.write(SSI + 0x60, byte);
    assert.equal(bench.read(SSI + 0x28) & 1, 1, "busy");
    bench.run(64 * bytes.length);
    const answer = bytes.map(() => bench.read(SSI + 0x60));
    bench.write(0x4001800c, 0);
    return answer;
  };
  assert.deepEqual(exchange(0x9f, 0, 0, 0).slice(1), [0xef, 0x40, 0x15]);
  assert.deepEqual(exchange(0x4b, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0).slice(5), bench.chip.flash.unique_id);
  assert.deepEqual(exchange(0x03, 0, 0, 2, 0, 0).slice(4), [3, 4]);
  bench.write(0x4001b000, 1); // no effect on the forced select
  bench.read(0x10000000);
  assert.match([...bench.chip.complaints.keys()].join(), /flash is read/);
});

test("boot2's checksum is CRC-32/MPEG-2", () => {
  assert.equal(crc32(Buffer.from("123456789")), 0x0376e6e7); // the check value that catalogues of CRCs give
});

test("ROM: a bad CRC of boot2 means BOOTSEL; so does the function that the table gives for UB", () => {
  const chip = new Chip();
  const program = new Thumb().load(5, 0x14).emit(0x8828, 0x88aa) // ldrh r0, [r5]; ldrh r2, [r5, #4]
    .load(1, 0x4255).blx(2).emit(0x4603).movs(0, 0).movs(1, 0).blx(3).label("end").branch("end");
  const image = flash_with(program);
  image[10] ^= 1;
  chip.flash.load(image);
  chip.power_on();
  assert.equal(chip.state, "bootsel");
  image[10] ^= 1;
  chip.flash.load(image);
  chip.power_on();
  assert.equal(chip.state, "running");
  chip.run_until(chip.queue.now + 1000);
  assert.equal(chip.state, "bootsel");
  assert.deepEqual([...chip.complaints], []);
});

test("ROSC gives the same bits for the same seed, about half of them ones", () => {
  const bits = (seed) => {
    const bench = Object.assign(new Bench(), { chip: new Chip({ seed }) });
    return Array.from({ length: 1000 }, () => bench.read(0x4006001c)).join("");
  };
  assert.equal(bits(7), bits(7));
  assert.notEqual(bits(7), bits(8));
  const ones = [...bits(7)].filter((bit) => bit === "1").length;
  assert.ok(ones > 450 && ones < 550, `${ones}`);
});
