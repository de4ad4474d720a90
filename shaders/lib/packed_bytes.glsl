// SPDX-License-Identifier: MIT
// Four pixels in one uint: comparison and masks without unpacking.

// 0x80 in every byte where a > b (unsigned): the carry out of a + (255 - b).
uint greater_bytes(uint a, uint b) {
  uint n = ~b;
  uint low = (a & 0x7f7f7f7fu) + (n & 0x7f7f7f7fu);
  return ((a & n) | ((a | n) & low)) & 0x80808080u;
}

// 0x80 flags of four bytes -> four bits, byte 0 in bit 0.
uint flags_to_bits(uint flags) { return ((flags >> 7) * 0x01020408u) >> 24; }

// Four bits -> 0xff in the bytes whose bit is set.
uint bits_to_bytes(uint bits) { return ((bits * 0x00204081u) & 0x01010101u) * 0xffu; }
