// SPDX-License-Identifier: MIT
// What the firmware can see of the boot ROM: its table, a few functions, the check of boot2. Written for this model;
// not the ROM's code. Functions are a breakpoint, which the model answers, and a return.

const FUNCTION_TABLE = 0x40, DATA_TABLE = 0x38, LOOKUP = 0xa0, LOCKED_UP = 0xc0, FIRST_FUNCTION = 0x100;

/** In the order of their breakpoint numbers. */
const FUNCTIONS = ["UB", "IF", "EX", "FC", "CX", "RE", "RP"];

// r0: table, r1: code -> r0: function or 0. Pairs of half-words, ended by a code of 0.
const LOOKUP_CODE = [
  0x8802, // ldrh r2, [r0]
  0x2a00, // cmp  r2, #0
  0xd005, // beq  none
  0x428a, // cmp  r2, r1
  0xd001, // beq  found
  0x3004, // adds r0, #4
  0xe7f8, // b    the start
  0x8840, // found: ldrh r0, [r0, #2]
  0x4770, // bx lr
  0x2000, // none: movs r0, #0
  0x4770, // bx lr
];

export function make_rom() {
  const rom = new Uint32Array(4096);
  const half = new Uint16Array(rom.buffer);
  const put = (address, words) => words.forEach((word, index) => { half[address / 2 + index] = word; });
  rom[0] = 0x20041f00;
  for (let vector = 1; vector < 4; vector++) rom[vector] = LOCKED_UP | 1;
  put(0x10, [0x754d, 0x0201, FUNCTION_TABLE, DATA_TABLE, LOOKUP | 1]);
  put(LOOKUP, LOOKUP_CODE);
  put(LOCKED_UP, [0xe7fe]);
  FUNCTIONS.forEach((name, index) => {
    const address = FIRST_FUNCTION + 4 * index;
    put(FUNCTION_TABLE + 4 * index, [name.charCodeAt(0) | (name.charCodeAt(1) << 8), address | 1]);
    put(address, [0xbe00 | index, 0x4770]);
  });
  return rom;
}

/** The processor met breakpoint `number` at an address of the ROM: does what that function does. */
export function call_rom(chip, number) {
  const { core, flash } = chip;
  const [r0, r1, r2] = core.registers;
  switch (FUNCTIONS[number]) {
    case "UB": chip.request_reset("bootsel"); break;
    case "EX": chip.ssi.set_serial(); break;
    case "CX": chip.ssi.set_execute_in_place(); break;
    case "RE": flash.bytes.fill(0xff, r0, r0 + r1); break;
    case "RP":
      for (let index = 0; index < r2; index++) flash.bytes[r0 + index] &= core.readUint8(r1 + index);
      break;
    default: break; // IF, FC: nothing that the model has
  }
}

/** CRC-32 as the ROM has it: polynomial 04c11db7, most significant bit first, from ffffffff. */
export function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) {
    crc ^= byte << 24;
    for (let bit = 0; bit < 8; bit++) crc = crc & 0x80000000 ? (crc << 1) ^ 0x04c11db7 : crc << 1;
  }
  return crc >>> 0;
}

/** Whether the ROM would start this flash: the last word of the first 256 bytes is the CRC of those before. */
export function boots(flash_bytes) {
  return crc32(flash_bytes.subarray(0, 252)) === new DataView(flash_bytes.buffer).getUint32(252, true);
}
