// SPDX-License-Identifier: MIT
// Four pixels in one uint: comparison and masks without unpacking.

// 0x80 in every byte where a > b (unsigned): the carry out of a + (255 - b).
uint greater_bytes(uint a, uint b) {
  uint n = ~b;
  uint low = (a & 0x7f7f7f7fu) + (n & 0x7f7f7f7fu);
  return ((a & n) | ((a | n) & low)) & 0x80808080u;
}

uvec4 greater_bytes(uvec4 a, uvec4 b) {
  uvec4 n = ~b;
  uvec4 low = (a & 0x7f7f7f7fu) + (n & 0x7f7f7f7fu);
  return ((a & n) | ((a | n) & low)) & 0x80808080u;
}

// 0xff in every byte that has 0x80.
uvec4 flags_to_bytes(uvec4 flags) { return flags | (flags - (flags >> 7)); }

// 0x80 flags of 16 bytes -> 16 bits, byte 0 in bit 0.
uint flags_to_bits(uvec4 flags) {
  uvec4 fours = ((flags >> 7) * 0x01020408u) >> 24;
  return fours.x | (fours.y << 4) | (fours.z << 8) | (fours.w << 12);
}

// 16 bits -> 0xff in the bytes whose bit is set.
uvec4 bits_to_bytes(uint bits) {
  uvec4 fours = (uvec4(bits) >> uvec4(0u, 4u, 8u, 12u)) & 15u;
  return ((fours * 0x00204081u) & 0x01010101u) * 0xffu;
}
