// SPDX-License-Identifier: MIT
// Step 4: unite every component of a tile with every one that it touches in the neighbouring tile of a listed pair.

bool touches(uint direction, uvec4 link, uvec4 other) {
  return direction == kAboveLeft    ? touches_above_left(link, other)
         : direction == kAbove      ? touches_above(link, other)
         : direction == kAboveRight ? touches_above_right(link, other)
                                    : touches_left(link, other);
}

void join_pair(uint camera, uint i) {
  uint base = cameras[camera].component_base;
  uint entry = pairs[4u * cameras[camera].tile_base + i];
  uint direction = entry >> 30, tile = entry & 0x3fffffffu;
  uint other_tile = direction == kLeft ? tile - 1u : tile - cameras[camera].tiles_x + direction - 1u;
  uvec4 link = imageLoad(links, int(base + tile)), other_tile_link = imageLoad(links, int(base + other_tile));
  bool several = is_divided(link), others = is_divided(other_tile_link);
  uint number = link.z;
  if (several) link = imageLoad(links, int(base + number));
  bool more = true;
  while (more) {
    uint border = direction == kLeft ? link_left(link) : link_top(link);
    uvec4 other_link = other_tile_link;
    uint other = other_link.z;
    bool more_others = border != 0u;
    while (more_others) {
      if (others) other_link = imageLoad(links, int(base + other));
      if (touches(direction, link, other_link)) unite(number, other, camera);
      other = other_link.z;
      more_others = others && other != 0u && spend_turn();
    }
    more = several && link.z != 0u && spend_turn();
    number = link.z;
    link = imageLoad(links, int(base + number));
  }
  if (!has_turns()) atomicOr(counters[camera].flags, kCounterChainTooLong);
}
