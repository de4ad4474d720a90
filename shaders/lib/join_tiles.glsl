// SPDX-License-Identifier: MIT
// Step 2: unite the components of a tile with those that they touch in the tiles right and below.

// Direction 0: right, 1: below left, 2: below, 3: below right. Border pixels of a component towards that side.
uint border_towards(uint direction, uvec4 link) {
  uint right = link.y >> 16, bottom = link.x >> 16;
  return direction == 0u ? right : direction == 1u ? bottom & 1u : direction == 2u ? bottom : bottom >> 15;
}

// Border pixels of the other component that face back, in the same numbering.
uint border_back(uint direction, uvec4 link) {
  uint left = link.y & 0xffffu, top = link.x & 0xffffu;
  return direction == 0u ? left : direction == 1u ? top >> 15 : direction == 2u ? top : top & 1u;
}

void join_tile(uint camera, uint i) {
  uint tile_base = cameras[camera].tile_base;
  uint slot_base = cameras[camera].slot_base;
  int tiles_x = int(cameras[camera].tiles_x), tiles_y = int(cameras[camera].tiles_y);
  uint mine = i + 1u;
  while (mine != 0u) {
    uint slot = slot_base + mine - 1u;
    uvec4 link = links[slot];
    for (uint direction = 0u; direction < 4u; direction++) {
      uint border = border_towards(direction, link);
      int x = int(link.w & 0xffffu) + (direction == 0u ? 1 : int(direction) - 2);
      int y = int(link.w >> 16) + (direction == 0u ? 0 : 1);
      uint spread = border | (border << 1) | (border >> 1);  // diagonal neighbours touch too
      uint other = 0u;
      if (border != 0u && x >= 0 && x < tiles_x && y < tiles_y) other = tile_map[tile_base + uint(y * tiles_x + x)];
      while (other != 0u) {
        uint other_slot = slot_base + other - 1u;
        uvec4 other_link = links[other_slot];
        if ((spread & border_back(direction, other_link)) != 0u) unite(slot, other_slot, camera);
        other = other_link.z;
      }
    }
    mine = link.z;
  }
}
