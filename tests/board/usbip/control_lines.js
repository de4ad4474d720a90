// SPDX-License-Identifier: MIT
// What a test says to running boards, a line each, and what they answer: "ok", "ok JSON" or "error TEXT".
//   [BOARD] adc CHANNEL MV | drive PIN 0|1|off | connect FROM TO | disconnect FROM TO | watch PIN | edges PIN | status
//   [BOARD] stream PIN (from then on each rise of it is told at once: "rise TIME_NS")
//   [BOARD] unplug | plug | stop-processor | mask-interrupts | power-off | power-on | reset | lose-ack COUNT | flash FILE
//   quit

const COMMANDS = {
  "adc": ({ board }, channel, mv) => board.adc_mv(number(channel), number(mv)),
  "drive": ({ board }, pin, level) => board.drive(number(pin), level === "off" ? undefined : number(level)),
  "connect": ({ board }, from, to) => board.connect(number(from), number(to)),
  "disconnect": ({ board }, from, to) => board.chip.pins.disconnect(number(from), number(to)),
  "watch": ({ board }, pin) => board.watch(number(pin)),
  "edges": ({ board }, pin) => board.edges(number(pin)).map(({ time_ns, level }) => [time_ns, level]),
  "unplug": (live) => live.unplug(),
  "plug": (live) => live.plug(),
  "stop-processor": ({ board }) => board.stop_processor(),
  "mask-interrupts": ({ board }) => board.mask_interrupts(),
  "power-off": ({ board }) => board.chip.power_off(),
  "power-on": ({ board }) => board.chip.power_on(),
  "reset": ({ board }) => board.chip.request_reset("run pin"),
  "lose-ack": ({ board }, count) => { board.host.faults.lose_ack = number(count); },
  "flash": (live, path) => live.flash(path),
  "status": status,
};

/** Tells `say` of each rise of a pin. */
function stream({ board }, pin, say) {
  board.watch(number(pin));
  board.chip.pins.on_edge(number(pin), (level, cycle) => {
    if (level === 1) say(`rise ${cycle * 8}`);
  });
}

function number(text) {
  const value = Number(text);
  if (text === undefined || !Number.isFinite(value)) throw new Error(`${text}: is not a number`);
  return value;
}

function status({ board, slips, failures, device }) {
  const { chip, host } = board;
  return { time_ns: board.time_ns, state: chip.state, device: device?.constructor.name ?? null, slips, failures,
    resets: chip.resets_seen, complaints: board.complaints, totals: host.totals };
}

/** Does one line; returns the answer. boards: LiveBoards; quit: what ends the server; say: sends a further line. */
export function do_line(boards, line, quit, say) {
  const words = line.trim().split(/\s+/);
  const index = /^\d+$/.test(words[0]) ? Number(words.shift()) : 0;
  const [name, ...rest] = words;
  if (name === "quit") {
    quit();
    return "ok";
  }
  if (boards[index] === undefined) return `error there is no board ${index}`;
  if (name === "stream") {
    stream(boards[index], rest[0], say);
    return "ok";
  }
  if (!(name in COMMANDS)) return `error ${name}: is not one of ${Object.keys(COMMANDS).join(", ")}, quit`;
  try {
    const result = COMMANDS[name](boards[index], ...rest);
    return result === undefined ? "ok" : `ok ${JSON.stringify(result)}`;
  } catch (error) {
    return `error ${error.message}`;
  }
}
