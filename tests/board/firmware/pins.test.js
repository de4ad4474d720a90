// SPDX-License-Identifier: MIT
// What leaves the pins, to the cycle of 8 ns, while a host does its worst.
import assert from "node:assert/strict";
import { test } from "node:test";
import { OUTPUT_PINS, STROBES_LOW, STROBE_PINS, SYNC_IN, SYNC_OUT, SyncBoard, TICKS_PER_US, adc_mv_of, periods, tally,
  widths } from "./sync_board.js";
import { C } from "./wire.js";

const SECONDS = Number(process.env.GLINT_BOARD_SECONDS ?? 10);
const us = (n) => n * TICKS_PER_US;

/** Delays and widths in ticks, all different, that fit the rate. */
function plan_for(rate_hz) {
  const slow = rate_hz <= 250;
  const strobe_us = Math.min(137, Math.floor(25000 / rate_hz) - 7);
  return OUTPUT_PINS.map((_, i) => (i < 4
    ? { delay_ticks: slow ? us(200 * i) + i : us(20 * i) + i, width_ticks: slow ? us(1000) + i : us(300) + i }
    : { delay_ticks: us(slow ? 788 : 488) + 3 * i, width_ticks: us(strobe_us) + i }));
}

function stage(board, rate_hz) {
  const plan = plan_for(rate_hz);
  board.stage_run({ period_ticks: Math.round(125e6 / rate_hz) });
  plan.forEach((output, i) => board.stage_output(i, output));
  return plan;
}

function assert_sequence(triggers) {
  triggers.forEach(({ sequence }, i) => assert.equal(sequence, i));
}

for (const rate_hz of [1, 90, 120, 250, 500, 1000]) {
  test(`${rate_hz} Hz on 8 outputs while the bus is full: every edge exact, every trigger reported`, () => {
    const board = new SyncBoard();
    const plan = stage(board, rate_hz);
    board.command(C.COMMAND_START);
    const hammer = board.board.hammer(C.TIME, 20000, 1);
    board.board.run_ms(SECONDS * 1000 + 50);
    hammer.stop();
    const period = Math.round(125e6 / rate_hz);
    const first = board.pulses(OUTPUT_PINS[0]);
    const least = Math.floor(SECONDS * rate_hz);
    assert.ok(first.length >= least, `${first.length} pulses`);
    plan.forEach(({ delay_ticks, width_ticks }, i) => {
      const pulses = board.pulses(OUTPUT_PINS[i]).slice(0, least);
      assert.deepEqual(widths(pulses), { [width_ticks]: pulses.length }, `width of output ${i}`);
      if (pulses.length > 1) assert.deepEqual(periods(pulses), { [period]: pulses.length - 1 }, `period of output ${i}`);
      assert.equal(pulses[0].rise - first[0].rise, delay_ticks - plan[0].delay_ticks, `delay of output ${i}`);
    });
    const triggers = board.triggers();
    assert.ok(triggers.length >= least, `${triggers.length} triggers reported`);
    assert_sequence(triggers);
    assert.deepEqual(tally(triggers.slice(1).map(({ tick }, i) => tick - triggers[i].tick)),
      triggers.length > 1 ? { [period]: triggers.length - 1 } : {});
    assert.equal(board.status().unsent, 0);
    assert.equal(board.status().fault, C.FAULT_NONE);
    assert.equal(hammer.failed, 0);
    // One after the other, a full-speed bus carries some 19,000 a second.
    assert.ok(hammer.done > 18000 * SECONDS, `${hammer.done} control transfers`);
    assert.equal(board.board.host.totals.toggle_errors ?? 0, 0);
    assert.deepEqual(board.board.complaints, []);
    console.log(`${rate_hz} Hz: ${first.length} frames, ${hammer.done} control transfers in ${SECONDS} s`);
  });
}

test("a tick reported is the tick of the edge: no constant error is left", () => {
  const board = new SyncBoard();
  const { board: bench } = board;
  board.stage_run({ period_ticks: us(5000), pulses: 20 });
  board.stage_output(0, { delay_ticks: 0, width_ticks: us(100) });
  board.command(C.COMMAND_START);
  bench.run_ms(110);
  const count = board.triggers().length;
  const difference = (from, pulses) => tally(board.triggers().slice(from).map(({ tick }, i) => pulses[i].rise - tick));
  const internal = difference(0, board.pulses(OUTPUT_PINS[0]));
  assert.equal(Object.keys(internal).length, 1);
  // The same by the other way, in which the processor times an edge at sync in.
  const from = bench.cycle;
  board.stage_run({ period_ticks: us(5000), flags: C.RUN_EXTERNAL });
  board.command(C.COMMAND_START);
  for (let i = 0; i < 200; ++i) {
    bench.run_ns(6e6 + 8 * 37 * i);
    bench.drive(SYNC_IN, 1);
    bench.run_us(20);
    bench.drive(SYNC_IN, 0);
  }
  bench.run_ms(6);
  const external = difference(count, board.pulses(OUTPUT_PINS[0], from));
  // An instruction that is under way ends before an interrupt begins.
  for (const offset of Object.keys(external))
    assert.ok(Math.abs(offset - Object.keys(internal)[0]) <= 12, `${offset}: ${JSON.stringify(external)}`);
});

test("from 90 to 250 Hz and back while running: no wrong pulse, no trigger lost", () => {
  const board = new SyncBoard();
  const plan = stage(board, 250);
  board.stage_run({ period_ticks: Math.round(125e6 / 90) });
  board.command(C.COMMAND_START);
  const hammer = board.board.hammer(C.STATUS, 5000);
  for (let change = 0; change < 12; ++change) {
    board.board.run_us(40000 + 1237 * change);
    board.stage_run({ period_ticks: Math.round(125e6 / (change % 2 === 0 ? 250 : 90)) });
    board.command(C.COMMAND_APPLY);
  }
  board.board.run_ms(40);
  hammer.stop();
  plan.forEach(({ width_ticks, delay_ticks }, i) => {
    const pulses = board.pulses(OUTPUT_PINS[i]);
    assert.deepEqual(Object.keys(widths(pulses)), [String(width_ticks)]);
    assert.deepEqual(Object.keys(periods(pulses)), ["500000", "1388889"]);
    assert.equal(pulses[0].rise - board.pulses(OUTPUT_PINS[0])[0].rise, delay_ticks);
  });
  assert_sequence(board.triggers());
  assert.equal(board.events(C.KIND_APPLIED).length, 12);
});

test("outputs take turns, bursts end, sync out repeats output 0", () => {
  const board = new SyncBoard();
  board.stage_run({ period_ticks: us(4000), pulses: 10, flags: C.RUN_SYNC_OUT });
  board.stage_output(0, { delay_ticks: us(10), width_ticks: us(500) });
  board.stage_output(1, { width_ticks: us(500), every_n: 2, phase: 1 });
  board.stage_output(4, { delay_ticks: us(100), width_ticks: us(50), every_n: 5, phase: 3 });
  board.command(C.COMMAND_START);
  board.board.run_ms(60);
  assert.equal(board.status().state, C.IDLE);
  assert.deepEqual(OUTPUT_PINS.map((pin) => board.pulses(pin).length), [10, 5, 0, 0, 2, 0, 0, 0]);
  assert.deepEqual(board.pulses(SYNC_OUT), board.pulses(OUTPUT_PINS[0]));
  const first = board.pulses(OUTPUT_PINS[0]);
  assert.deepEqual(board.pulses(OUTPUT_PINS[1]).map(({ rise }) => first.findIndex((pulse) => pulse.rise === rise + us(10))), [1, 3, 5, 7, 9]);
  assert.deepEqual(board.triggers().map(({ outputs }) => outputs), [1, 3, 1, 0x13, 1, 3, 1, 3, 0x11, 3]);
});

test("an output that is switched on while others run is in step at once", () => {
  const board = new SyncBoard();
  board.stage_run({ period_ticks: us(4000) });
  board.stage_output(0, { width_ticks: us(500) });
  board.command(C.COMMAND_START);
  board.board.run_ms(41);
  board.stage_output(6, { delay_ticks: us(33), width_ticks: us(77) });
  board.command(C.COMMAND_APPLY);
  board.board.run_ms(41);
  const first = board.pulses(OUTPUT_PINS[0]), late = board.pulses(OUTPUT_PINS[6]);
  assert.ok(late.length >= 8);
  for (const { rise } of late) assert.ok(first.some((pulse) => pulse.rise === rise - us(33)));
});

test("active-low triggers idle high from the start of a run on", () => {
  const board = new SyncBoard();
  board.stage_run({ period_ticks: us(4000), pulses: 5 });
  board.stage_output(2, { flags: C.OUTPUT_ENABLED | C.OUTPUT_ACTIVE_LOW, width_ticks: us(500) });
  board.command(C.COMMAND_START);
  board.board.run_ms(40);
  assert.equal(board.board.level(4), 1);
  assert.deepEqual(widths(board.pulses(4, 0, 0)), { [us(500)]: 5 });
});

test("the jumper makes strobes active low, and nothing else does", () => {
  for (const jumper of [false, true]) {
    const board = new SyncBoard({ enumerates: true, grounded: jumper ? [STROBES_LOW] : [] });
    board.stage_run({ period_ticks: us(4000), pulses: 5 });
    for (const low of [false, true]) {
      board.stage_output(4, { flags: C.OUTPUT_ENABLED | (low ? C.OUTPUT_ACTIVE_LOW : 0), width_ticks: us(50) });
      const reason = board.refusal(() => board.command(C.COMMAND_START));
      assert.equal(reason, low === jumper ? C.REFUSED_NOTHING : C.REFUSED_POLARITY);
      if (low !== jumper) continue;
      board.board.run_ms(40);
      assert.equal(board.board.level(6), jumper ? 1 : 0);
      assert.deepEqual(widths(board.pulses(6, 0, jumper ? 0 : 1)), { [us(50)]: 5 });
    }
    board.board.adc_mv(0, adc_mv_of(15000));
    board.board.run_ms(5);
    for (const pin of STROBE_PINS) assert.equal(board.board.level(pin), jumper ? 1 : 0, "held off when locked out");
  }
});

test("the self-test finds the output that is wired to sync in, and measures it", () => {
  const board = new SyncBoard();
  for (const output of [1, 5]) {
    board.board.connect(OUTPUT_PINS[output], SYNC_IN);
    for (const tested of [output, 7]) {
      board.command(C.COMMAND_SELFTEST, tested);
      board.board.run_ms(400);
      const result = board.get("selftest", C.SELFTEST);
      assert.equal(result.state, C.SELFTEST_DONE);
      assert.equal(result.sent, 32);
      assert.equal(result.seen, tested === output ? 32 : 0);
      if (tested !== output) continue;
      for (const [least, most, sent] of [["least_width_ticks", "most_width_ticks", "width_ticks"],
        ["least_period_ticks", "most_period_ticks", "period_ticks"]]) {
        assert.ok(Math.abs(result[least] - result[sent]) <= result.resolution_ticks, least);
        assert.ok(Math.abs(result[most] - result[sent]) <= result.resolution_ticks, most);
      }
    }
    board.board.chip.pins.disconnect?.(OUTPUT_PINS[output], SYNC_IN);
  }
});

test("all strobes are low from power-up to the first start", () => {
  const board = new SyncBoard();
  board.board.run_ms(100);
  for (const pin of STROBE_PINS) assert.deepEqual(board.board.edges(pin).filter(({ level }) => level === 1), []);
});
