// SPDX-License-Identifier: MIT
// The light, and what happens when something dies: seen at the pins of the very program that users flash.
import assert from "node:assert/strict";
import { test } from "node:test";
import { OUTPUT_PINS, STROBE_PINS, SyncBoard, TICKS_PER_US, adc_mv_of, widths } from "./sync_board.js";
import { C } from "./wire.js";

const us = (n) => n * TICKS_PER_US;
const CAP_WIDTH = us(300), CAP_DUTY_PERMILLE = 25;

function start_all(board, period_us, { strobe_us = 100, delay_us = 788 } = {}) {
  board.stage_run({ period_ticks: us(period_us) });
  OUTPUT_PINS.forEach((_, i) => board.stage_output(i, i < 4 ? { width_ticks: us(300) }
    : { delay_ticks: us(delay_us), width_ticks: us(strobe_us) }));
  board.command(C.COMMAND_START);
}

test("strobes go off within 0.2 ms of the supply crossing 14.0 V, and come back below 13.8 V", () => {
  for (let trial = 0; trial < 8; ++trial) {
    const board = new SyncBoard();
    const { board: bench } = board;
    // A strobe every 4 ms for 100 us would rarely be caught: bursts of phases show when the pins are let go.
    start_all(board, 4000, { delay_us: 0 });
    bench.run_ms(20);
    // So that the crossing falls into, or just before, a pulse of the strobes.
    const last = board.pulses(STROBE_PINS[0]).at(-1);
    const crossing = last.rise + us(4000) * (Math.ceil((bench.cycle - last.rise) / us(4000)) + 1) - us(40 * trial);
    bench.adc_mv(0, (time_ns) => adc_mv_of(time_ns / 8 < crossing ? 13900 : 14020));
    bench.run_ms(30);
    const locked = board.events(C.KIND_LOCKED);
    assert.equal(locked.length, 1);
    assert.ok(locked[0].cycle - crossing < us(1400), "reported at the next poll of the host");
    for (const pin of STROBE_PINS) {
      assert.equal(bench.level(pin), 0);
      const after = bench.edges(pin).filter(({ cycle }) => cycle > crossing + us(200));
      assert.deepEqual(after, [], `edges of GP${pin} more than 0.2 ms after the crossing`);
    }
    assert.ok(board.pulses(OUTPUT_PINS[0]).at(-1).rise > bench.cycle - us(8100), "triggers go on");
    bench.adc_mv(0, adc_mv_of(13850));
    bench.run_ms(50);
    assert.equal(board.events(C.KIND_REARMED).length, 0);
    const rearmed = bench.cycle;
    bench.adc_mv(0, adc_mv_of(13700));
    bench.run_ms(40);
    assert.equal(board.events(C.KIND_REARMED).length, 1);
    const back = board.pulses(STROBE_PINS[0], rearmed);
    assert.ok(back.length > 3);
    assert.deepEqual(Object.keys(widths(back)), [String(us(100))], "no pulse cut short when they come back");
  }
});

for (const [kind, kill] of [["stops", (bench) => bench.stop_processor()], ["masks all interrupts", (bench) => bench.mask_interrupts()]]) {
  test(`a processor that ${kind} at 1 kHz leaves all pins low within two periods, and the watchdog resets it`, () => {
    let board, bench, death;
    for (let phase_us = 0; phase_us < 1000; phase_us += 50) {
      board = new SyncBoard();
      bench = board.board;
      start_all(board, 1000, { strobe_us: 20, delay_us: 488 });
      bench.run_ms(20);
      bench.run_us(phase_us);
      death = bench.cycle;
      kill(bench);
      bench.run_ms(150);
      for (const pin of OUTPUT_PINS) {
        assert.equal(bench.level(pin), 0);
        const last = bench.edges(pin).at(-1).cycle;
        assert.ok(last - death <= us(2000), `GP${pin}: ${(last - death) / 125} us`);
        assert.deepEqual(Object.keys(widths(board.pulses(pin))), [String(us(pin < 6 ? 300 : 20))], "all pulses whole");
      }
    }
    bench.run_ms(150);
    const [, reset] = bench.chip.resets_seen;
    assert.equal(reset.cause, "watchdog");
    assert.ok(Math.abs(reset.cycle - death - us(200_000)) < us(1000), `${(reset.cycle - death) / 125} us`);
    bench.run_until_ready(1000);
    const epochs = bench.attachments.map(({ reports }) => reports);
    assert.equal(epochs.length, 2);
    const status = board.status();
    assert.equal(status.reset_reason, C.RESET_WATCHDOG);
    assert.equal(status.state, C.IDLE);
    assert.equal(status.flags & C.FLAG_WATCHDOG, C.FLAG_WATCHDOG);
    bench.run_ms(100);
    assert.deepEqual(OUTPUT_PINS.map((pin) => bench.level(pin)), OUTPUT_PINS.map(() => 0));
  });
}

test("an interrupt that hangs is ended by the watchdog, too", () => {
  const board = new SyncBoard();
  const { board: bench } = board;
  start_all(board, 4000);
  bench.run_ms(20);
  const before = board.status().epoch;
  // The interrupt of the timer becomes an endless loop: 'b .'
  const { chip } = bench;
  const vectors = new DataView(chip.sram.buffer, chip.sram.byteOffset);
  const handler = vectors.getUint32(16 * 4, true) & ~1;
  vectors.setUint16(handler - 0x20000000, 0xe7fe, true);
  bench.run_ms(230);
  assert.equal(chip.resets_seen.at(-1).cause, "watchdog");
  bench.run_until_ready(1000);
  assert.notEqual(board.status().epoch, before);
});

test("refusals say which output and which limit", () => {
  const board = new SyncBoard();
  const refused = (output, period_us, values) => {
    board.stage_run({ period_ticks: us(period_us) });
    board.stage_output(output, values);
    const reason = board.refusal(() => board.command(C.COMMAND_START));
    const { refusal_output, refusal_limit } = board.status();
    board.stage_output(output, { flags: 0 });
    return [reason, refusal_output, refusal_limit];
  };
  assert.deepEqual(refused(5, 100_000, { width_ticks: CAP_WIDTH + 1 }), [C.REFUSED_STROBE_WIDTH, 5, CAP_WIDTH]);
  assert.deepEqual(refused(6, 4000, { width_ticks: us(100) + 1 }), [C.REFUSED_STROBE_DUTY, 6, CAP_DUTY_PERMILLE]);
  assert.deepEqual(refused(4, 4000, { flags: 3, width_ticks: us(50) }), [C.REFUSED_POLARITY, 4, 0]);
  assert.deepEqual(refused(0, 499, { width_ticks: us(50) }), [C.REFUSED_PERIOD_SHORT, 0xff, us(500)]);
  const limits = board.get("limits", C.LIMITS);
  for (const [field, cap, reason] of [["lockout_mv", 14000, C.REFUSED_LOCKOUT], ["rearm_mv", 13800, C.REFUSED_REARM],
    ["strobe_max_duty_permille", 25, C.REFUSED_STROBE_DUTY], ["strobe_max_width_ticks", CAP_WIDTH, C.REFUSED_STROBE_WIDTH]]) {
    assert.equal(limits[field], cap);
    assert.equal(board.refusal(() => board.set("limits", C.LIMITS, { ...limits, [field]: cap + 1 })), reason);
    assert.equal(board.status().refusal_limit, cap);
  }
});

/** Linear congruential, so that every run is the same. */
function random_from(seed) {
  let state = BigInt(seed);
  return (most) => {
    state = (state * 6364136223846793005n + 1442695040888963407n) & 0xffffffffffffffffn;
    return Number((state >> 33n) % BigInt(most + 1));
  };
}

test("10,000 reports of a mad host: no strobe longer, none more often than the caps", () => {
  const up_to = random_from(4711);
  const often = (one_in) => up_to(one_in - 1) !== 0;
  const board = new SyncBoard();
  const { board: bench } = board;
  const sent = Number(process.env.GLINT_BOARD_REPORTS ?? 10000);
  const state = { done: 0, refused: 0, pending: 0 };
  const any_report = () => {
    const kind = up_to(15);
    if (kind < 5) {
      const output = up_to(7);
      return ["output", C.OUTPUT + output, { flags: often(100) ? up_to(1) : up_to(3), every_n: often(3) ? 1 : 1 + up_to(4),
        phase: up_to(100) === 0 ? up_to(6) : 0, delay_ticks: us(up_to(often(50) ? 900 : 20000)),
        width_ticks: often(100) ? us(1) + up_to(us(80)) : up_to(often(2) ? 2 * CAP_WIDTH : 0xffffffff) }];
    }
    if (kind < 8) {
      return ["run", C.RUN, { flags: often(40) ? 0 : up_to(7), period_ticks: us(often(100) ? 4000 + up_to(8000) : up_to(11_000_000)),
        pulses: often(20) ? 0 : up_to(5), code_group: often(100) ? up_to(1) * 18 : up_to(1100),
        dark_width_ticks: often(100) ? 0 : up_to(us(400)), keepalive_ms: often(30) ? 0 : up_to(200) }];
    }
    if (kind < 14) {
      // Not the bootloader, from which nobody comes back; RESET wants a number that is not guessed.
      return ["command", C.COMMAND, { command: often(5) ? 1 + up_to(2) : up_to(6), argument: up_to(9) }];
    }
    return ["limits", C.LIMITS, { lockout_mv: 13000 + up_to(1200), rearm_mv: 12000 + up_to(2000),
      strobe_max_duty_permille: often(5) ? 25 : up_to(30), strobe_max_width_ticks: often(5) ? CAP_WIDTH : up_to(2 * CAP_WIDTH) }];
  };
  for (let n = 0; n < sent; ++n) {
    try {
      board.set(...any_report());
      ++state.done;
    } catch (error) {
      if (error.code !== "STALL") throw error;
      ++state.refused;
    }
    if (!often(50)) bench.adc_mv(0, adc_mv_of(often(8) ? 12000 : 13000 + up_to(2000)));
    bench.run_us(up_to(often(10) ? 2000 : 20000));
  }
  let seen = 0;
  for (const pin of STROBE_PINS) {
    const pulses = board.pulses(pin);
    seen += pulses.length;
    pulses.forEach(({ rise, fall }, i) => {
      assert.ok(fall - rise <= CAP_WIDTH, `GP${pin}: ${fall - rise} ticks`);
      if (i > 0) {
        const before = pulses[i - 1];
        assert.ok((rise - before.rise) * CAP_DUTY_PERMILLE >= (before.fall - before.rise) * 1000, `GP${pin} at ${rise}`);
      }
    });
  }
  assert.deepEqual(bench.complaints, []);
  assert.equal(bench.chip.resets_seen.length, 1, "and the firmware has lived through it");
  assert.ok(seen > 0.05 * sent, `${seen} pulses`);
  console.log(`${sent} reports, ${state.refused} refused, ${seen} pulses of strobes in ${(bench.time_ns / 1e9).toFixed(1)} s`);
});
