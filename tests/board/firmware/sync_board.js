// SPDX-License-Identifier: MIT
// The simulated board with glint's firmware, spoken to in its own words.
import { Board } from "../sim/board.js";
import { C, decode, encode } from "./wire.js";

export const TICKS_PER_US = 125;
export const TRIGGER_PINS = [2, 3, 4, 5], STROBE_PINS = [6, 7, 8, 9], SYNC_IN = 14, SYNC_OUT = 15, STROBES_LOW = 10;
export const OUTPUT_PINS = [...TRIGGER_PINS, ...STROBE_PINS];
/** At the pin, behind the divider of 8. */
export const adc_mv_of = (supply_mv) => supply_mv / 8;

export const FIRMWARE = process.env.GLINT_FIRMWARE;

export class SyncBoard {
  /** options: those of Board.boot, supply_mv, and pins that are wired to ground. */
  constructor({ supply_mv = 12000, grounded = [], watch = [...OUTPUT_PINS, SYNC_OUT], ...options } = {}) {
    if (FIRMWARE === undefined) throw new Error("GLINT_FIRMWARE must name glint-sync.uf2");
    this.board = Board.boot(FIRMWARE, { watch, ...options });
    if (grounded.length > 0) {
      for (const pin of grounded) this.board.drive(pin, 0);
      this.board.power_cycle();
      this.board.run_until_ready();
    }
    this.board.adc_mv(0, adc_mv_of(supply_mv));
    this.board.run_ms(30); // strobes may fire from 12 ms after the start on
  }

  set(struct, report_id, values) {
    try {
      this.board.set_feature(encode(struct, report_id, values));
    } catch (error) {
      if (error.code !== "STALL") throw error;
      const { refusal, refusal_output, refusal_limit } = this.status();
      throw Object.assign(error, { message: `refused: ${refusal}, output ${refusal_output}, limit ${refusal_limit}` });
    }
  }

  get(struct, report_id) {
    return decode(struct, this.board.get_feature(report_id));
  }

  status() {
    return this.get("status", C.STATUS);
  }

  command(command, argument = 0) {
    this.set("command", C.COMMAND, { command, argument });
  }

  /** The reason for which a SET is refused; 0 if it is taken. */
  refusal(action) {
    try {
      action();
    } catch (error) {
      if (error.code !== "STALL") throw error;
      return this.status().refusal;
    }
    return 0;
  }

  stage_run(values) {
    this.set("run", C.RUN, values);
  }

  stage_output(output, values) {
    this.set("output", C.OUTPUT + output, { flags: C.OUTPUT_ENABLED, every_n: 1, ...values });
  }

  stop() {
    this.command(C.COMMAND_STOP);
    this.board.run_until(() => this.status().state === C.IDLE, 30000, 1000);
  }

  /** Input reports so far, decoded, with the cycle at which the host had them. */
  reports() {
    return this.board.reports.map(({ cycle, data }) => ({ cycle, ...decode("input", data) }));
  }

  events(kind) {
    return this.reports().filter((report) => report.kind === kind);
  }

  /** [{ tick, sequence, outputs, flags }] of all triggers reported. */
  triggers() {
    return this.events(C.KIND_TRIGGERS).flatMap((report) => {
      let { tick } = report;
      return Array.from({ length: report.count }, (_, i) => {
        if (i > 0) tick += report.step_ticks[i - 1];
        return { tick, run: report.run, sequence: report.sequence + i, outputs: report.outputs[i],
          flags: report.trigger_flags[i] };
      });
    });
  }

  /** Whole pulses of a pin since `from`: [{ rise, fall }] in cycles. */
  pulses(pin, from = 0, active = 1) {
    const pulses = [];
    for (const { cycle, level } of this.board.edges(pin).slice(1)) {
      if (level === active) pulses.push({ rise: cycle });
      else if (pulses.length > 0) pulses.at(-1).fall = cycle;
    }
    return pulses.filter(({ rise, fall }) => rise >= from && fall !== undefined);
  }
}

/** { value: how often } of what `of` makes of neighbours. */
export function tally(values) {
  const counts = new Map();
  for (const value of values) counts.set(value, (counts.get(value) ?? 0) + 1);
  return Object.fromEntries(counts);
}
export const widths = (pulses) => tally(pulses.map(({ rise, fall }) => fall - rise));
export const periods = (pulses) => tally(pulses.slice(1).map(({ rise }, i) => rise - pulses[i].rise));
