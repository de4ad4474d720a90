// SPDX-License-Identifier: MIT
// A tile of 16 x 8 pixels as a uvec4 of bits: word r / 2 holds rows r (low half) and r + 1, bit x is column x.

uint top_row(uvec4 tile) { return tile.x & 0xffffu; }
uint bottom_row(uvec4 tile) { return tile.w >> 16; }

// The 8 bits of one column, row 0 in bit 0.
uint tile_column(uvec4 tile, uint column) {
  uvec4 pair = tile >> column;
  uvec4 two = (pair & 1u) | ((pair >> 15) & 2u);
  return two.x | (two.y << 2) | (two.z << 4) | (two.w << 6);
}

// Every pixel and its neighbours in the same row.
uvec4 widen(uvec4 tile) { return tile | ((tile << 1) & 0xfffefffeu) | ((tile >> 1) & 0x7fff7fffu); }

// All eight neighbours.
uvec4 dilate(uvec4 tile) {
  uvec4 h = widen(tile);
  uvec4 down = (h << 16) | uvec4(0u, h.xyz >> 16);
  uvec4 up = (h >> 16) | uvec4(h.yzw << 16, 0u);
  return h | down | up;
}

// Rows that have any bit: row r in bit r / 2 * 16 + r % 2.
uvec4 rows_with_bits(uvec4 tile) {
  return uvec4(notEqual(tile & 0xffffu, uvec4(0u))) | (uvec4(notEqual(tile >> 16, uvec4(0u))) << 1);
}

uint count_bits(uvec4 words) {
  ivec4 n = bitCount(words);
  return uint(n.x + n.y + n.z + n.w);
}

// True only if the tile is one 8-connected component that a look at neighbouring rows proves to be one: every row has at
// most one run, and each row's run touches the next one's.
bool is_one_piece(uvec4 tile) {
  uvec4 starts = tile & ~((tile << 1) & 0xfffefffeu);
  uint runs = count_bits(starts);
  uint rows = count_bits(rows_with_bits(tile));
  uvec4 below = (tile >> 16) | uvec4(tile.yzw << 16, 0u);
  uint touching = count_bits(rows_with_bits(widen(tile) & below));
  return runs == rows && touching + 1u == rows;
}

// The 8-connected component of the first set bit of `tile`; empty for an empty tile.
uvec4 first_component(uvec4 tile) {
  uvec4 lowest = tile & (~tile + 1u);
  uvec4 seed = lowest;
  seed.y = tile.x != 0u ? 0u : seed.y;
  seed.z = (tile.x | tile.y) != 0u ? 0u : seed.z;
  seed.w = (tile.x | tile.y | tile.z) != 0u ? 0u : seed.w;
  uvec4 component = seed;
  bool grew;
  do {
    uvec4 next = dilate(component) & tile;
    next = dilate(next) & tile;
    grew = next != component;
    component = next;
  } while (grew);
  return component;
}
