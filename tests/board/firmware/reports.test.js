// SPDX-License-Identifier: MIT
// What the host hears: every report once and in order, also after it did not listen; time; resets.
import assert from "node:assert/strict";
import { test } from "node:test";
import { SYNC_IN, SyncBoard, TICKS_PER_US, tally } from "./sync_board.js";
import { C, encode } from "./wire.js";

const us = (n) => n * TICKS_PER_US;

function start(board, rate_hz) {
  board.stage_run({ period_ticks: Math.round(125e6 / rate_hz) });
  board.stage_output(0, { width_ticks: us(100) });
  board.command(C.COMMAND_START);
}

test("at 2 kHz several triggers share a report, and none is missing", () => {
  const board = new SyncBoard();
  start(board, 2000);
  board.board.run_ms(1000);
  const reports = board.reports(), triggers = board.triggers();
  reports.forEach(({ report_no }, i) => assert.equal(report_no, i + reports[0].report_no));
  triggers.forEach(({ sequence }, i) => assert.equal(sequence, i));
  assert.ok(triggers.length >= 1990);
  assert.deepEqual(tally(triggers.slice(1).map(({ tick }, i) => tick - triggers[i].tick)), { 62500: triggers.length - 1 });
  assert.equal(board.status().unsent, 0);
});

test("a host that did not listen can fetch what it missed", () => {
  const board = new SyncBoard({ watch: [2] });
  start(board, 500);
  board.board.host.interrupts.length = 0; // nobody has the device open
  board.board.run_ms(500);
  board.board.device.poll();
  board.board.run_ms(100);
  const heard = board.reports();
  const missing = [];
  for (let i = 1; i < heard.length; ++i)
    for (let number = heard[i - 1].report_no + 1; number < heard[i].report_no; ++number) missing.push(number);
  assert.ok(missing.length > 30, `${missing.length} missing`);
  assert.equal(missing.length, heard.at(-1).unsent);
  const all = new Map(heard.map((report) => [report.report_no, report]));
  for (const report_no of missing) {
    board.set("fetch", C.FETCH, { report_no });
    all.set(report_no, board.get("input", C.FETCH));
  }
  let sequence = 0;
  for (const report_no of [...all.keys()].sort((a, b) => a - b)) {
    const report = all.get(report_no);
    if (report.kind !== C.KIND_TRIGGERS) continue;
    assert.equal(report.sequence, sequence);
    sequence += report.count;
  }
});

test("a lost acknowledgement makes no report come twice or get lost", () => {
  const board = new SyncBoard();
  start(board, 500);
  for (let i = 0; i < 50; ++i) {
    board.board.host.faults.lose_ack = 1;
    board.board.run_ms(7);
  }
  const reports = board.reports();
  reports.forEach(({ report_no }, i) => assert.equal(report_no, i + reports[0].report_no));
});

test("the time told lies between question and answer, near the question", () => {
  const board = new SyncBoard();
  const offsets = [];
  for (let i = 0; i < 50; ++i) {
    board.board.run_us(1000 + 137 * i);
    const asked = board.board.cycle;
    const { tick } = board.get("time", C.TIME);
    const answered = board.board.cycle;
    offsets.push({ least: tick - answered, most: tick - asked });
  }
  const least = Math.max(...offsets.map((offset) => offset.least)), most = Math.min(...offsets.map((offset) => offset.most));
  assert.ok(least <= most, "one offset between tick and cycle fits all answers");
  assert.ok(most - least < us(100));
});

test("each reset has another epoch and says why", () => {
  const board = new SyncBoard();
  const { board: bench } = board;
  const seen = new Set([board.status().epoch]);
  for (const [reason, how] of [[C.RESET_COMMAND, () => board.command(C.COMMAND_RESET, C.MAGIC_RESET)],
    [C.RESET_POWER, () => {
      bench.chip.seed += 1; // of the noise that the epoch comes from
      bench.power_cycle();
    }], [C.RESET_COMMAND, () => board.command(C.COMMAND_RESET, C.MAGIC_RESET)]]) {
    start(board, 90);
    how();
    bench.run_ms(60);
    bench.run_until_ready(2000);
    bench.run_ms(30);
    assert.equal(bench.device.reports.length, 1);
    const [booted] = board.reports();
    assert.equal(booted.kind, C.KIND_BOOTED);
    assert.equal(booted.report_no, 0);
    assert.equal(booted.detail, reason);
    assert.ok(!seen.has(booted.epoch));
    seen.add(booted.epoch);
    assert.equal(board.status().state, C.IDLE);
  }
});

test("the bootloader comes when it is asked for with its number, and not otherwise", () => {
  const board = new SyncBoard();
  const { board: bench } = board;
  assert.equal(board.refusal(() => board.command(C.COMMAND_BOOTLOADER, 1)), C.REFUSED_MAGIC);
  start(board, 90);
  board.command(C.COMMAND_BOOTLOADER, C.MAGIC_BOOTLOADER);
  bench.run_ms(100);
  assert.equal(bench.chip.state, "bootsel");
});

test("a run that needs its host ends when the cable is pulled; one that does not goes on", () => {
  for (const keepalive_ms of [0, 500]) {
    const board = new SyncBoard({ watch: [2] });
    board.stage_run({ period_ticks: us(10000), keepalive_ms });
    board.stage_output(0, { width_ticks: us(100) });
    board.command(C.COMMAND_START);
    board.board.run_ms(100);
    board.board.unplug();
    board.board.run_ms(1200);
    const before = board.pulses(2).length;
    board.board.run_ms(200);
    assert.equal(board.pulses(2).length - before, keepalive_ms === 0 ? 20 : 0);
  }
});

test("an external trigger: fixed latency, its tick measured, edges too soon ignored", () => {
  const board = new SyncBoard({ watch: [2, 6] });
  const { board: bench } = board;
  board.stage_run({ period_ticks: us(5000), flags: C.RUN_EXTERNAL });
  board.stage_output(0, { width_ticks: us(100) });
  board.stage_output(4, { delay_ticks: us(788), width_ticks: us(100) });
  board.command(C.COMMAND_START);
  assert.equal(board.status().state, C.WAITING);
  const hammer = bench.hammer(C.STATUS, 10000);
  const edges = [];
  for (let i = 0; i < 100; ++i) {
    bench.run_ns(5.2e6 + 8 * 1237 * (i % 9));
    edges.push(bench.cycle);
    for (const level of [1, 0, 1, 0]) {
      bench.drive(SYNC_IN, level);
      bench.run_us(30);
    }
  }
  bench.run_ms(6);
  hammer.stop();
  const fired = board.pulses(2), lit = board.pulses(6), triggers = board.triggers();
  assert.equal(fired.length, 100);
  assert.equal(triggers.length, 100);
  const latency = tally(fired.map(({ rise }, i) => rise - edges[i]));
  assert.deepEqual(Object.values(latency), [100], "the same for all");
  assert.ok(Object.keys(latency)[0] <= 10);
  lit.forEach(({ rise }, i) => assert.ok(Math.abs(rise - fired[i].rise - us(788)) <= 1));
  const offset = fired[0].rise - triggers[0].tick;
  triggers.forEach(({ tick, flags }, i) => {
    assert.ok(Math.abs(fired[i].rise - tick - offset) < us(1), `tick ${i}: ${fired[i].rise - tick - offset}`);
    assert.equal(flags, C.TRIGGER_EXTERNAL);
  });
  assert.ok(board.status().ignored_edges >= 99);
});

test("STOP while an edge is waited for: what comes later is neither a pulse nor a report", () => {
  const board = new SyncBoard({ watch: [2] });
  const { board: bench } = board;
  board.stage_run({ period_ticks: us(5000), flags: C.RUN_EXTERNAL });
  board.stage_output(0, { width_ticks: us(100) });
  board.command(C.COMMAND_START);
  for (let i = 0; i < 5; ++i) {
    bench.run_ms(6);
    bench.drive(SYNC_IN, 1);
    bench.run_us(20);
    bench.drive(SYNC_IN, 0);
  }
  bench.run_ms(900);
  board.command(C.COMMAND_STOP);
  bench.run_us(500);
  bench.drive(SYNC_IN, 1);
  bench.run_ms(10);
  assert.equal(board.pulses(2).length, 5);
  assert.equal(board.triggers().length, 5);
  const [stopped] = board.events(C.KIND_STOPPED);
  assert.equal(stopped.sequence, 5);
  assert.ok(stopped.tick > board.triggers()[4].tick + us(900_000));
  assert.equal(board.status().state, C.IDLE);
});

test("an edge at the very moment of STOP is a whole pulse and a report, or neither", () => {
  for (let offset = -40; offset < 40; ++offset) {
    const board = new SyncBoard({ watch: [2] });
    const { board: bench } = board;
    board.stage_run({ period_ticks: us(5000), flags: C.RUN_EXTERNAL });
    board.stage_output(0, { width_ticks: us(100) });
    board.command(C.COMMAND_START);
    bench.run_ms(6);
    bench.at_ns(bench.time_ns + 60_000 + 500 * offset, () => bench.drive(SYNC_IN, 1));
    board.command(C.COMMAND_STOP);
    bench.run_ms(10);
    const pulses = board.pulses(2);
    assert.equal(pulses.length, board.triggers().length, `${offset}`);
    for (const { rise, fall } of pulses) assert.equal(fall - rise, us(100), `${offset}`);
    assert.equal(board.status().state, C.IDLE);
  }
});

test("lost acknowledgements of control transfers: no answer is the one before", () => {
  const board = new SyncBoard();
  start(board, 500);
  let queries = 0, stale = 0;
  for (let i = 0; i < 300; ++i) {
    board.board.host.faults.lose_ack = 1;
    const { queries: now } = board.get("time", C.TIME);
    if (now <= queries) ++stale;
    queries = now;
    board.board.run_us(10 * (i % 7));
    assert.equal(board.get("status", C.STATUS).report_id, C.STATUS);
  }
  assert.equal(stale, 0);
});

test("a report whose number is not that of the request is refused", () => {
  const board = new SyncBoard();
  start(board, 500);
  const stop = encode("command", C.COMMAND, { command: C.COMMAND_STOP });
  const { device } = board.board;
  const setup = Uint8Array.from([0x21, 9, C.RUN, 3, device.interface_number, 0, stop.length, 0]);
  assert.throws(() => board.board.finish(board.board.host.control(setup, stop)), { code: "STALL" });
  assert.equal(board.status().state, C.RUNNING);
});
