// SPDX-License-Identifier: MIT
// A tile of 16 x 8 pixels as a uvec4 of bits: word r / 2 holds rows r (low half) and r + 1, bit x is column x.

uint tile_row(uvec4 tile, uint row) { return (tile[row >> 1] >> ((row & 1u) * 16u)) & 0xffffu; }

// The 8 bits of one column, row 0 in bit 0.
uint tile_column(uvec4 tile, uint column) {
  uvec4 pair = tile >> column;
  uvec4 two = (pair & 1u) | ((pair >> 15) & 2u);
  return two.x | (two.y << 2) | (two.z << 4) | (two.w << 6);
}

// All eight neighbours.
uvec4 dilate(uvec4 tile) {
  uvec4 h = tile | ((tile << 1) & 0xfffefffeu) | ((tile >> 1) & 0x7fff7fffu);
  uvec4 down = (h << 16) | uvec4(0u, h.xyz >> 16);
  uvec4 up = (h >> 16) | uvec4(h.yzw << 16, 0u);
  return h | down | up;
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
