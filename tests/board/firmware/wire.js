// SPDX-License-Identifier: MIT
// Reports of the sync board as objects, by firmware/protocol/sync_report.h itself: there is no second definition.
import { readFileSync } from "node:fs";

const HEADER = new URL("../../../firmware/protocol/sync_report.h", import.meta.url);
const BYTES = { char: 1, uint8_t: 1, uint16_t: 2, uint32_t: 4, uint64_t: 8 };

function number_of(text, constants) {
  const value = text.trim().replace(/u$/, "");
  if (/^(0x[0-9a-f]+|\d+)$/i.test(value)) return Number(value);
  if (value in constants) return constants[value];
  const difference = /^(\w+) - (\d+)$/.exec(value);
  if (difference) return constants[difference[1]] - Number(difference[2]);
  throw new Error(`sync_report.h: '${text}' is no number that wire.js understands`);
}

function read_constants(text) {
  const constants = {};
  for (const [, name, value] of text.matchAll(/^#define (GLINT_SYNC_\w+) (0x[0-9a-f]+u?|\d+)\s*$/gim))
    constants[name] = number_of(value, constants);
  for (const [, name, value] of text.matchAll(/\b(GLINT_SYNC_\w+) = (0x[0-9a-f]+|\d+)/gi))
    constants[name] = number_of(value, constants);
  return constants;
}

/** { name: { field: { offset, type, count } } }, packed: the header's own assertions exclude gaps. */
function read_structs(text, constants) {
  const structs = {};
  for (const [, name, body] of text.matchAll(/typedef struct (\w+) \{([^}]*)\}/g)) {
    const fields = {};
    let offset = 0;
    for (const [, type, field, count] of body.matchAll(/^\s*(\w+)\s+(\w+)(?:\[([^\]]+)\])?;/gm)) {
      const repeats = count === undefined ? undefined : number_of(count, constants);
      fields[field] = { offset, type, count: repeats };
      offset += BYTES[type] * (repeats ?? 1);
    }
    if (offset !== constants.GLINT_SYNC_REPORT_BYTES) throw new Error(`sync_report.h: ${name} has ${offset} bytes`);
    structs[name] = fields;
  }
  return structs;
}

const text = readFileSync(HEADER, "utf8").replace(/\/\/.*$/gm, "");
const constants = read_constants(text);
/** GLINT_SYNC_... without the prefix. */
export const C = new Proxy(constants, {
  get(target, name) {
    const value = target[`GLINT_SYNC_${String(name)}`];
    if (value === undefined) throw new Error(`sync_report.h has no GLINT_SYNC_${String(name)}`);
    return value;
  },
});
const structs = read_structs(text, constants);

function access(view, type, offset, value) {
  if (value === undefined) {
    switch (BYTES[type]) {
      case 1: return view.getUint8(offset);
      case 2: return view.getUint16(offset, true);
      case 4: return view.getUint32(offset, true);
      default: return Number(view.getBigUint64(offset, true)); // ticks stay exact for two years
    }
  }
  switch (BYTES[type]) {
    case 1: return view.setUint8(offset, value);
    case 2: return view.setUint16(offset, value, true);
    case 4: return view.setUint32(offset, value, true);
    default: return view.setBigUint64(offset, BigInt(value), true);
  }
}

/** The bytes of a report; fields that are not named are 0. */
export function encode(struct, report_id, values = {}) {
  const bytes = new Uint8Array(C.REPORT_BYTES);
  const view = new DataView(bytes.buffer);
  for (const [name, value] of Object.entries({ report_id, protocol: C.PROTOCOL_MAJOR, ...values })) {
    const field = structs[`glint_sync_${struct}`][name];
    if (field === undefined) throw new Error(`glint_sync_${struct} has no field ${name}`);
    access(view, field.type, field.offset, value);
  }
  return bytes;
}

export function decode(struct, bytes) {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const values = {};
  for (const [name, { offset, type, count }] of Object.entries(structs[`glint_sync_${struct}`])) {
    const at = (i) => access(view, type, offset + i * BYTES[type]);
    values[name] = count === undefined ? at(0) : Array.from({ length: count }, (_, i) => at(i));
  }
  return values;
}
